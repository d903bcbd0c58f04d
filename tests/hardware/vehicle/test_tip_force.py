"""A force sensor in the tip: what cannot be used counts as no reading, and is told once."""

from __future__ import annotations

import math
import time
from types import SimpleNamespace
from typing import Any

import pytest

from doorman.exceptions import BackendError
from doorman.flight.journal import Journal
from doorman.hardware.vehicle import TipReading, VehicleLinks
from doorman.hardware.vehicle.tip_force import TipForce
from doorman.recording import Recorder

NOW = 50.0


def said_by(source: Any) -> tuple[float | None, list[tuple[float, str]]]:
    sensor = TipForce(source, 0.05)
    return sensor.read(NOW), sensor.events()


def test_a_new_finite_reading_is_the_force():
    assert said_by(lambda: TipReading(1.25, NOW - 0.01)) == (1.25, [])


def fails() -> TipReading:
    raise OSError("unplugged")


@pytest.mark.parametrize(
    ("source", "words"),
    [
        (lambda: None, "no reading"),
        (lambda: TipReading(math.nan, NOW), "nan"),
        (lambda: TipReading(math.inf, NOW), "inf"),
        (lambda: TipReading(1.0, NOW - 0.06), "old"),
        (lambda: TipReading(1.0, math.nan), "old"),
        (fails, "unplugged"),
    ],
)
def test_what_cannot_be_used_is_no_reading(source, words):
    force, events = said_by(source)
    assert force is None
    assert len(events) == 1 and events[0][0] == NOW and words in events[0][1]


def test_only_changes_are_told():
    readings = [None, None, TipReading(1.0, NOW), TipReading(1.1, NOW), None]
    sensor = TipForce(lambda: readings.pop(0), 0.05)
    assert [sensor.read(NOW) for _ in range(5)] == [None, None, 1.0, 1.1, None]
    assert len(sensor.events()) == 3 and not sensor.events()


def test_the_journal_tells():
    sensor, silent = TipForce(lambda: None, 0.05), SimpleNamespace(events=list)
    sensor.read(time.monotonic())
    links: Any = SimpleNamespace(autopilot=silent, servos=silent, mocap=None, tip_force=sensor, door=None)
    supervisor: Any = SimpleNamespace(findings=[])
    journal = Journal(links, supervisor, Recorder(None, {}))
    journal.take(time.monotonic() - 1.0)
    assert ["tip_force: no reading" in line for line in journal.lines] == [True]


def test_a_gripper_has_no_such_sensor():
    config: Any = SimpleNamespace(gripper=True)
    with pytest.raises(BackendError, match="tip_force"):
        VehicleLinks(config, lambda: None)
