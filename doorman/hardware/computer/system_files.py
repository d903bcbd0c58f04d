"""Files for the vehicle's system: udev rules, limits and a systemd unit, shipped beside this module."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

_FOLDER = Path(__file__).parent / "files"


@dataclass(frozen=True)
class SystemFile:
    name: str  # as shipped
    place: str  # where it belongs

    @property
    def text(self) -> str:
        return (_FOLDER / self.name).read_text(encoding="utf-8")


SYSTEM_FILES = {
    "udev": SystemFile("99-doorman.rules", "/etc/udev/rules.d/99-doorman.rules"),
    "limits": SystemFile("doorman.conf", "/etc/security/limits.d/doorman.conf"),
    "service": SystemFile("doorman.service", "/etc/systemd/system/doorman.service"),
}
"""By short name."""
