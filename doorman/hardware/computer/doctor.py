"""Doctor: what is missing on this computer before it can fly, each with the command that mends it. Nothing is changed."""

from __future__ import annotations

import os
import re
import resource
import shutil
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from enum import Enum
from importlib.metadata import PackageNotFoundError, requires, version
from pathlib import Path

from packaging.requirements import Requirement

from doorman.compilation import cache_content
from doorman.exceptions import how_to_install
from doorman.hardware.mocap.connection import RECEIVE_BUFFER
from doorman.hardware.scheduling import PRIORITY

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
"""Files by short name."""


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
        soft, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
        return os.geteuid() == 0 or soft == resource.RLIM_INFINITY or soft >= PRIORITY

    @staticmethod
    def free_space(folder: Path) -> int:
        return shutil.disk_usage(folder).free

    @staticmethod
    def processors() -> int:
        """Cores that we may use."""
        return len(os.sched_getaffinity(0))


DISTRIBUTION = "doorman-uam"
LEAST_SPACE = 2_000_000_000
"""Least free space for recordings [bytes]."""
LARGEST_SLEW = 1000
"""Largest slew of the clock that the servos' stamps allow [ppm]."""
_INSTALL = how_to_install("hardware").partition(": ")[2]
_GOOD_CLOCKS = ("tsc", "arch_sys_counter", "kvm-clock")


class Complaint(Enum):
    NONE = "ok"
    WORSE = "could be better"  # it can fly, worse
    MISSING = "no"  # it cannot fly so


@dataclass(frozen=True)
class Row:
    name: str
    complaint: Complaint
    found: str
    command: str = ""  # that mends it; nothing where it is well


def judged(name: str, well: bool, found: str, wrong: str, command: str, complaint: Complaint = Complaint.WORSE) -> Row:
    """A row that is well as found, or wrong with the command that mends it."""
    return Row(name, Complaint.NONE, found) if well else Row(name, complaint, wrong, command)


def examine(host: Host, folder: Path) -> list[Row]:
    looks: tuple[Callable[[], Iterator[Row]], ...] = (
        _versions, lambda: _devices(host), lambda: _scheduling(host), lambda: _clock(host), lambda: _resources(host, folder),
    )  # fmt: skip
    return [row for look in looks for row in look()]


def _versions() -> Iterator[Row]:
    wrong, missing = [], []
    try:
        texts = requires(DISTRIBUTION) or []
    except PackageNotFoundError:
        words = "doorman is not installed, so its dependencies cannot be checked"
        yield Row("versions", Complaint.WORSE, words, _INSTALL)
        return
    for requirement in map(Requirement, texts):
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": "hardware"}):
            continue
        try:
            found = version(requirement.name)
        except PackageNotFoundError:
            missing.append(requirement.name)
            continue
        if not requirement.specifier.contains(found, prereleases=True):
            wrong.append(f"{requirement.name} {found}, wanted {requirement.specifier}")
    words = "; ".join([*wrong, *([f"not installed: {', '.join(missing)}"] if missing else [])])
    yield judged("versions", not words, "all packages are there, and new enough", words, _INSTALL, Complaint.MISSING)


def device_row(host: Host, name: str, device: Path, found: str = "") -> Row:
    """Whether this user may use a device."""
    words = "this user may not read and write it; log in again after this"
    return judged(
        name, host.may(device), f"{found}this user may read and write it", words, "sudo usermod -aG dialout $USER",
        Complaint.MISSING,
    )  # fmt: skip


def _devices(host: Host) -> Iterator[Row]:
    devices = host.serial_devices()
    if not devices:
        yield Row("serial devices", Complaint.WORSE, "none is plugged in: no /dev/ttyUSB* or /dev/ttyACM*", "lsusb")
    for device in devices:
        yield device_row(host, device.name, device)
    for path, timer in host.each("sys/bus/usb-serial/devices/*/latency_timer"):
        yield judged(
            f"latency timer of {Path(path).parent.name}", timer == "1", "1 ms",
            f"{timer} ms; to keep the change: doorman system udev", f"echo 1 | sudo tee /{path}", Complaint.MISSING,
        )  # fmt: skip
    ignored = "ID_MM_DEVICE_IGNORE" in (host.read(SYSTEM_FILES["udev"].place.lstrip("/")) or "")
    if host.runs("ModemManager") and not ignored:
        yield Row("ModemManager", Complaint.WORSE, "it sends to a Pixhawk that is plugged in",
                  "sudo systemctl disable --now ModemManager")  # fmt: skip


def _scheduling(host: Host) -> Iterator[Row]:
    yield judged(
        "real-time priority", host.real_time_allowed(), "allowed",
        "not allowed: programs delay the controller; log in again after this",
        f"doorman system limits | sudo tee {SYSTEM_FILES['limits'].place}",
    )  # fmt: skip
    if host.processors() < 2:
        yield Row("processors", Complaint.MISSING, "controller and planner share one core", "nproc")
    governors = {text for _, text in host.each("sys/devices/system/cpu/cpu*/cpufreq/scaling_governor")}
    yield judged(
        "governor", not governors - {"performance"}, "performance" if governors else "the system has none",
        f"{', '.join(sorted(governors))}: the cores speed up slowly",
        "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor",
    )  # fmt: skip


def _clock(host: Host) -> Iterator[Row]:
    folder = "sys/devices/system/clocksource/clocksource0"
    source, better = host.read(f"{folder}/current_clocksource"), host.read(f"{folder}/available_clocksource") or ""
    best = next((name for name in _GOOD_CLOCKS if name in better.split()), "tsc")
    yield judged(
        "clock", source is None or source in _GOOD_CLOCKS, source or "not known",
        f"{source}, slow to read; the computer has {better or 'no other'}",
        f"echo {best} | sudo tee /{folder}/current_clocksource",
    )  # fmt: skip
    if host.runs("chronyd"):
        text = host.read("etc/chrony/chrony.conf") or host.read("etc/chrony.conf") or ""
        slews = re.findall(r"^\s*maxslewrate\s+([\d.]+)", text, re.MULTILINE)
        if not slews or float(slews[-1]) > LARGEST_SLEW:
            yield Row("time server", Complaint.WORSE, "chrony may slew the clock by 8 %: the servos' samples look late then",
                      "echo maxslewrate 500 | sudo tee -a /etc/chrony/chrony.conf; sudo systemctl restart chrony")  # fmt: skip


def _resources(host: Host, folder: Path) -> Iterator[Row]:
    text = host.read("proc/sys/net/core/rmem_max")
    if text is not None and text.isdigit() and int(text) < RECEIVE_BUFFER // 2:  # the kernel doubles what is asked for
        yield Row("network buffers", Complaint.WORSE, f"{text} bytes: a busy computer loses poses",
                  f"sudo sysctl -w net.core.rmem_max={RECEIVE_BUFFER}")  # fmt: skip
    there = next(one for one in (folder, *folder.absolute().parents) if one.exists())
    free = host.free_space(there)
    words = f"{free / 1e9:.1f} GB free at {there}"
    yield judged("disk", free >= LEAST_SPACE, f"{free / 1e9:.0f} GB free", words, f"du -sh {folder}")
    count, words = cache_content().kernels, "none is compiled yet: the first flight waits for some minutes"
    yield judged("kernels", bool(count), f"{count} compiled", words, "doorman warmup")
