"""Rows of the checklist about a measured door: against the map, with the numbers that go into the task."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from virtual_time import CLOCK

from doorman.flight.ground.door import measured_door
from doorman.flight.ground.judgements import Verdict
from doorman.hardware.door import (
    CallableSource,
    DoorSample,
    DoorSensor,
    DoorSensorConfig,
    FrameSample,
    LeafGeometry,
    LeafSample,
    Mark,
    MarkPose,
)
from doorman.hardware.vehicle_file import write_values
from doorman.model import Model
from doorman.scenario import Scenario

MODEL = Model(Scenario.load("push"))


def rows(joint: float | None, position=(0.0, 0.0, 0.0), yaw: float = 0.0, sees: bool = True):
    """Checks by name, of a leaf at a joint value and a frame at a place."""
    turn = (math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw))

    def read() -> DoorSample:
        leaf = None if joint is None else LeafSample(CLOCK.now(), joint)
        return DoorSample(leaf, FrameSample(CLOCK.now(), MarkPose(position, turn)) if sees else None)

    config = DoorSensorConfig(
        source="program", leaf=Mark("leaf"), frame=Mark("frame"), motion=LeafGeometry.of(MODEL.door)
    )
    still = SimpleNamespace(position_time=10.0, position=np.zeros(3), attitude=np.zeros(3))
    links = SimpleNamespace(
        door=DoorSensor(CallableSource(read), config),
        mocap=None,
        clock=CLOCK,
        autopilot=SimpleNamespace(state=lambda: still),
    )
    return {check.name: check for check in measured_door(MODEL, links)}


CLOSED = MODEL.door.joint_value(MODEL.start_angle)


def test_a_door_where_the_map_has_it_is_good():
    found = rows(CLOSED)
    assert [one.verdict for one in found.values()] == [Verdict.GOOD] * 2
    assert "90.0°" in found["leaf"].found


def test_a_door_beside_the_map_is_told_with_the_numbers():
    frame = rows(CLOSED, (0.03, -0.04, 0.0))["door's frame"]
    assert frame.verdict is Verdict.WARNING and "5.0 cm" in frame.found
    assert "door.position = [0.030, -0.040, 0.000], door.yaw = 0.0000" in frame.advice


@pytest.mark.parametrize(("position", "yaw"), [((0.2, 0.0, 0.0), 0.0), ((0.0, 0.0, 0.0), 0.3)])
def test_a_door_beyond_its_search_keeps_the_vehicle_on_the_ground(position, yaw):
    frame = rows(CLOSED, position, yaw)["door's frame"]
    assert frame.verdict is Verdict.BAD and "door.position" in frame.found


def test_an_ajar_leaf_is_known_before_take_off():
    leaf = rows(CLOSED - 0.3)["leaf"]
    assert leaf.verdict is Verdict.WARNING and "72.8°" in leaf.found


def test_what_is_not_seen_is_a_warning():
    found = rows(None, sees=False)
    assert {one.verdict for one in found.values()} == {Verdict.WARNING} and "no reading" in found["leaf"].found


def test_without_a_sensor_there_are_no_rows():
    assert not list(measured_door(MODEL, SimpleNamespace(door=None)))


def test_the_measured_place_is_written_into_a_task_with_comments(tmp_path):
    task = tmp_path / "task.toml"
    task.write_text('# my door\n[contact]\nkind = "push"  # it only pushes\n')
    write_values(task, {"door.position": [0.03, -0.04, 0.0], "door.yaw": 0.02}, Scenario)
    text = task.read_text()
    assert "# it only pushes" in text
    assert Model(str(task)).door.yaw == 0.02
