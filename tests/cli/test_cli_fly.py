"""`doorman fly`: who hears the signals. The flights themselves are in `tests/rig`."""

from __future__ import annotations

import json
import signal
from types import SimpleNamespace
from typing import cast

import pytest
from typer.testing import CliRunner, Result

from doorman.cli import app
from doorman.cli.vehicles.flight import Mission, _ctrl_c
from doorman.flight import FlightSession
from doorman.flight.guarded import STOPPING
from doorman.hardware.vehicle import VehicleLinks
from doorman.model import Model

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)


class Session:
    """Notes what it is asked."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def interrupt(self) -> None:
        self.asked.append("interrupt")

    def terminate(self) -> None:
        self.asked.append("terminate")


@pytest.fixture
def session():
    before = {number: signal.getsignal(number) for number in SIGNALS}
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # the tests themselves may run by nohup
    yield Session()
    for number, handler in before.items():
        signal.signal(number, handler)


def test_signals_go_to_the_session_as_long_as_it_flies(session):
    before = [signal.getsignal(number) for number in SIGNALS]
    with _ctrl_c(cast(FlightSession, session)):
        for number in SIGNALS:
            signal.raise_signal(number)
    assert session.asked == ["interrupt", "terminate", "terminate", "terminate"]
    assert [signal.getsignal(number) for number in SIGNALS] == before


def test_a_terminal_that_is_gone_does_not_concern_a_flight_by_nohup(session):
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    with _ctrl_c(cast(FlightSession, session)):
        signal.raise_signal(signal.SIGHUP)
    assert session.asked == []


def test_nothing_stops_the_program_while_it_flies(session):
    """Ctrl-Z for Ctrl-C: the vehicle would hear nothing any more."""
    before = [signal.getsignal(number) for number in STOPPING]
    with _ctrl_c(cast(FlightSession, session)):
        for number in STOPPING:
            signal.raise_signal(number)
    assert [signal.getsignal(number) for number in STOPPING] == before


class Autopilot:
    """Has parameters that cannot be written."""

    config = SimpleNamespace(write_parameters=True)

    def __init__(self, written: tuple[str, ...]) -> None:
        self.written = written

    def state(self) -> SimpleNamespace:
        return SimpleNamespace(armed=False)

    def check_parameters(self) -> tuple[str, ...]:
        return ("MIS_TAKEOFF_ALT is wrong",)

    def fix_parameters(self) -> tuple[str, ...]:
        return self.written


@pytest.mark.parametrize(("written", "words"), [((), "No parameter could be written"), (("COM_A",), "COM_A. Reboot")])
def test_parameters_that_were_to_be_written_ground_the_vehicle_whether_they_could_be_or_not(written, words, capsys):
    links = SimpleNamespace(autopilot=Autopilot(written))
    result = Mission(Model("paper")).written(cast(VehicleLinks, links))
    assert result is not None and not result["ready"] and words in result["message"]
    assert "by hand: MIS_TAKEOFF_ALT" in capsys.readouterr().out


def fly(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["fly", *arguments], env={"COLUMNS": "200", "TERM": "dumb"})


def test_a_dry_run_without_hardware_says_what_a_flight_needs():
    result = fly("pull", "--dry-run", "--json")
    assert result.exit_code == 1, result.output
    rows = {row["name"]: row for row in json.loads(result.stdout)["checklist"]}
    assert (rows["autopilot"]["verdict"], rows["servos"]["verdict"]) == ("no", "no")
    assert "6 rotors" in rows["autopilot"]["found"] and "--pixhawk" in rows["autopilot"]["advice"]
    assert "eta_4, and one for the gripper" in rows["servos"]["found"] and rows["scenario"]["verdict"] == "ok"
    half = fly("pull", "--dry-run", "--json", "--pixhawk", "udp:14540")
    verdicts = {row["name"]: row["verdict"] for row in json.loads(half.stdout)["checklist"]}
    assert (verdicts["autopilot"], verdicts["servos"]) == ("warning", "no")
    assert fly("pull").exit_code == 2


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        *(("--duration", value, "--duration") for value in ("nan", "0", "-1", "inf")),
        ("--link", "pixhawk.vehicel_system=1", "no such setting"),
        ("--link", "nonsense", "--link"),
        ("--link", "servos.ids=[", "--link servos.ids"),
    ],
)
def test_a_value_that_cannot_be_is_an_error_that_names_its_option(option, value, words):
    result = fly("paper", "--pixhawk", "udp:14540", "--servos", "/dev/null", option, value)
    assert result.exit_code == 2 and words in result.output
