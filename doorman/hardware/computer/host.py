"""What a Linux computer tells about itself in files; below another root in tests."""

from __future__ import annotations

import os
import resource
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

REAL_TIME_PRIORITY = 20
"""Priority requested in the real-time class."""


@dataclass(frozen=True)
class Host:
    root: Path = Path("/")  # where its files begin

    def read(self, path: str) -> str | None:
        try:
            return (self.root / path).read_text(encoding="utf-8", errors="replace").strip()
        except OSError:
            return None

    def each(self, pattern: str) -> Iterator[tuple[str, str]]:
        for file in sorted(self.root.glob(pattern)):
            path = str(file.relative_to(self.root))
            text = self.read(path)
            if text is not None:
                yield path, text

    def serial_devices(self) -> list[Path]:
        return sorted([*self.root.glob("dev/ttyUSB*"), *self.root.glob("dev/ttyACM*")])

    def runs(self, program: str) -> bool:
        return any(name == program[:15] for _, name in self.each("proc/[0-9]*/comm"))

    @staticmethod
    def may(device: Path) -> bool:
        return os.access(device, os.R_OK | os.W_OK)

    @staticmethod
    def real_time_allowed() -> bool:
        """Whether threads may run in the real-time class."""
        soft, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
        return os.geteuid() == 0 or soft == resource.RLIM_INFINITY or soft >= REAL_TIME_PRIORITY

    @staticmethod
    def free_space(folder: Path) -> int:
        return shutil.disk_usage(folder).free

    @staticmethod
    def processors() -> int:
        """Cores that we may use."""
        return len(os.sched_getaffinity(0))
