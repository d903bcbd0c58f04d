"""Files for the vehicle's system: they parse as their programs read them, and say what the code needs."""

from __future__ import annotations

import configparser
import re
import shlex
from typing import Any

import pytest
import typer.main
from command_line import run as doorman

from doorman.cli import app
from doorman.hardware.computer.doctor import SYSTEM_FILES
from doorman.hardware.scheduling import PRIORITY


def printed(name: str) -> str:
    done = doorman("system", name)
    assert done.exit_code == 0
    return done.stdout


@pytest.mark.parametrize("name", SYSTEM_FILES)
def test_the_first_line_says_where_it_belongs(name):
    assert SYSTEM_FILES[name].place in printed(name).splitlines()[0]


def test_udev_rules():
    rules = [line for line in printed("udev").splitlines() if line and not line.startswith("#")]
    one = r'(ACTION|SUBSYSTEM|DRIVER|ATTRS?\{\w+\}|ENV\{\w+\}|GROUP|MODE|SYMLINK)(==|=|\+=)"[^"]+"'
    for rule in rules:
        assert re.fullmatch(rf"{one}(, {one})*", rule), rule
        matches, assigns = re.findall(r'\w+(?:\{\w+\})?=="', rule), re.findall(r'[\w}]\+?="', rule)
        assert matches and assigns, rule
    assert any('ATTR{latency_timer}="1"' in rule and 'DRIVER=="ftdi_sio"' in rule for rule in rules)
    assert sum('SYMLINK+="pixhawk"' in rule for rule in rules) >= 4 and any(
        'SYMLINK+="servos"' in rule for rule in rules
    )


def test_the_unit_gives_what_a_flight_needs_and_never_starts_by_itself():
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.optionxform = str
    unit.read_string(printed("service"))
    assert set(unit) == {"DEFAULT", "Unit", "Service"}  # no [Install]
    service = unit["Service"]
    assert int(service["LimitRTPRIO"]) >= PRIORITY
    assert service["KillSignal"] == "SIGTERM" and int(service["TimeoutStopSec"]) >= 60 and service["Restart"] == "no"
    assert "fly $FLIGHT" in service["ExecStart"]


def test_the_flight_of_the_unit_parses():
    example = re.search(r"FLIGHT=(.*)", printed("service"))[1]
    command: Any = typer.main.get_command(app)
    flight = command.commands["fly"].make_context("fly", shlex.split(example)).params
    assert flight["yes"] is True and flight["vehicle"] == "/etc/doorman/vehicle.toml"


def test_limits():
    rows = [line.split() for line in printed("limits").splitlines() if not line.startswith("#")]
    assert ["@dialout", "-", "rtprio", str(PRIORITY)] in rows
