"""Doctor: each fault of a made computer is told with a command, and a computer without faults has none."""

from __future__ import annotations

import json
import resource
from importlib.metadata import PackageNotFoundError
from unittest.mock import Mock

import pytest
from command_line import run as doorman

from doorman.hardware.computer import doctor
from doorman.hardware.computer.doctor import Complaint, Host, examine

GOOD = {
    "sys/bus/usb-serial/devices/ttyUSB0/latency_timer": "1",
    "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor": "performance",
    "sys/devices/system/clocksource/clocksource0/current_clocksource": "tsc",
    "proc/sys/net/core/rmem_max": "212992",
    "proc/17/comm": "chronyd",
    "etc/chrony/chrony.conf": "server a\nmaxslewrate 500\n",
    "dev/ttyUSB0": "",
}


@pytest.fixture
def computer(tmp_path, monkeypatch):
    """Makes a computer that is as it should be, but for some files."""
    monkeypatch.setattr(Host, "real_time_allowed", staticmethod(lambda: True))
    monkeypatch.setattr(Host, "processors", staticmethod(lambda: 4))
    monkeypatch.setattr(doctor, "requires", lambda name: ["numpy>=1", "no-such-package ; extra == 'docs'"])
    monkeypatch.setattr(Host, "free_space", staticmethod(lambda folder: 50_000_000_000))

    def make(**changed: str) -> Host:
        files = GOOD | {name.replace("__", "/"): text for name, text in changed.items()}
        for name, text in files.items():
            (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / name).write_text(text)
        return Host(tmp_path)

    return make


def complaints(host, tmp_path, monkeypatch, kernels=7):
    monkeypatch.setattr(doctor, "cache_content", lambda: Mock(kernels=kernels))
    return [row for row in examine(host, tmp_path / "runs") if row.complaint is not Complaint.NONE]


def test_a_computer_as_it_should_be(computer, tmp_path, monkeypatch):
    assert complaints(computer(), tmp_path, monkeypatch) == []


@pytest.mark.parametrize(
    ("file", "text", "name", "complaint", "command"),
    [
        ("sys__bus__usb-serial__devices__ttyUSB1__latency_timer", "16", "latency timer of ttyUSB1", "no", "echo 1 | sudo tee"),
        ("sys__devices__system__cpu__cpu1__cpufreq__scaling_governor", "powersave", "governor", "could be better", "performance"),
        ("sys__devices__system__clocksource__clocksource0__current_clocksource", "hpet", "clock", "could be better", "echo tsc"),
        ("proc__99__comm", "ModemManager", "ModemManager", "could be better", "disable --now ModemManager"),
        ("proc__sys__net__core__rmem_max", "4096", "network buffers", "could be better", "sysctl -w net.core.rmem_max="),
        ("etc__chrony__chrony.conf", "server a\n", "time server", "could be better", "maxslewrate 500"),
        ("etc__chrony__chrony.conf", "maxslewrate 83333\n", "time server", "could be better", "maxslewrate 500"),
    ],
)  # fmt: skip
def test_a_file_that_is_wrong(file, text, name, complaint, command, computer, tmp_path, monkeypatch):
    (row,) = complaints(computer(**{file: text}), tmp_path, monkeypatch)
    assert (row.name, row.complaint.value) == (name, complaint)
    assert command in row.command and row.found


def test_rules_that_keep_modem_manager_away(computer, tmp_path, monkeypatch):
    rules = doorman("system", "udev").stdout
    host = computer(proc__99__comm="ModemManager", **{"etc__udev__rules.d__99-doorman.rules": rules})
    assert complaints(host, tmp_path, monkeypatch) == []


@pytest.mark.parametrize(
    ("method", "value", "name", "command"),
    [
        ("real_time_allowed", False, "real-time priority", "doorman system limits"),
        ("processors", 1, "processors", "nproc"),
        ("free_space", 1e8, "disk", "du -sh"),
        ("may", False, "ttyUSB0", "usermod -aG dialout"),
        ("serial_devices", [], "serial devices", "lsusb"),
    ],
)
def test_what_the_system_does_not_give(method, value, name, command, computer, tmp_path, monkeypatch):
    host = computer()
    monkeypatch.setattr(Host, method, staticmethod(lambda *_: value))
    (row,) = complaints(host, tmp_path, monkeypatch)
    assert row.name == name and command in row.command


def test_packages_that_are_missing_or_old(computer, tmp_path, monkeypatch):
    wanted = ["numpy>=999", "no-such-package>=1 ; extra == 'hardware'", "another ; extra == 'docs'"]
    host = computer()
    monkeypatch.setattr(doctor, "requires", lambda name: wanted)
    (row,) = complaints(host, tmp_path, monkeypatch)
    assert row.complaint is Complaint.MISSING and row.command.startswith("pip install")
    assert "numpy" in row.found and "no-such-package" in row.found and "another" not in row.found
    monkeypatch.setattr(doctor, "requires", Mock(side_effect=PackageNotFoundError))
    (row,) = complaints(host, tmp_path, monkeypatch)
    assert "not installed" in row.found and row.command.startswith("pip install")


def test_no_kernels_yet(computer, tmp_path, monkeypatch):
    (row,) = complaints(computer(), tmp_path, monkeypatch, kernels=0)
    assert row.command == "doorman warmup"


def test_real_time_by_the_limit(monkeypatch):
    monkeypatch.setattr("os.geteuid", lambda: 1000)
    for limit, allowed in ((0, False), (19, False), (20, True), (resource.RLIM_INFINITY, True)):
        monkeypatch.setattr(resource, "getrlimit", lambda kind, limit=limit: (limit, limit))
        assert Host.real_time_allowed() is allowed


def test_the_command(tmp_path):
    done = doorman("doctor", "--runs", str(tmp_path / "none" / "yet"), "--json")
    rows = json.loads(done.stdout)
    assert done.exit_code == int(any(row["complaint"] == "no" for row in rows))
    assert {"versions", "disk", "kernels", "governor", "clock"} <= {row["name"] for row in rows}
    assert all(row["command"] for row in rows if row["complaint"] != "ok")
    assert "found" in doorman("doctor").output
