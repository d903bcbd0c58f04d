"""A sensor of the door is believed as long as the tip does not contradict it; what lies is told, once."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from doorman.control.estimation.door_watch import DoorWatch
from doorman.control.estimation.estimator import Tie
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.signals import FrameReading, LeafReading, Measurement

MODEL = Model(Scenario.load("push"))
DOOR = MODEL.door
RATE = math.radians(-10.0)
NOISE = 0.002


def flight(reads, tie=Tie.PUSHING, duration: float = 4.0, bias: float = 0.0):
    """A tip that has met the leaf after 1 s and moves it; `reads` says what a sensor makes of (time, true angle)."""
    watch, random, none = DoorWatch(MODEL), np.random.default_rng(0), np.zeros(3)
    believed, before = [], None
    for k in range(int(duration * 100)):
        now = 0.01 * k
        angle = MODEL.start_angle + RATE * max(now - 1.5, 0.0)
        tip = angle + bias + (0.05 if now < 1.0 else 0.0)
        told = reads(now - 0.02, MODEL.start_angle + RATE * max(now - 1.52, 0.0))
        leaf = None
        if told is not None:
            leaf = LeafReading(DOOR.joint_value(told + NOISE * random.normal()), now - 0.02, NOISE)
        measured = Measurement(now, none, none, none, none, np.zeros(4), np.zeros(4), now, leaf=leaf)
        believed.append(watch.checked(measured, before, tie if now > 1.005 else Tie.FREE).leaf is not None)
        rate = RATE if now > 1.5 else 0.0
        before = SimpleNamespace(time=now, tip_angle=tip, door_rate=rate, touching=now > 1.0, face_offset=0.0)
    return watch, np.array(believed)


@pytest.mark.parametrize("bias", [0.0, 0.02, -0.02])
@pytest.mark.parametrize("tie", [Tie.PUSHING, Tie.GRIPPED])
def test_a_true_sensor_is_believed_though_the_map_is_off(bias, tie):
    watch, believed = flight(lambda time, angle: angle, tie, bias=bias)
    assert believed.all() and not watch.lied


LIES = {
    "freeze": lambda time, angle: angle if time < 2.0 else MODEL.start_angle + RATE * 0.5,
    "jump": lambda time, angle: angle + (math.radians(10.0) if time > 2.0 else 0.0),
    "late": lambda time, angle: MODEL.start_angle + RATE * max(time - 1.8, 0.0),
    "upside down": lambda time, angle: 2.0 * MODEL.start_angle - angle,
    "wrong object": lambda time, angle: MODEL.start_angle - 0.5 * math.sin(2.0 * time),
}


@pytest.mark.parametrize("lie", LIES)
def test_what_lies_is_told_once_and_not_believed_again(lie):
    watch, believed = flight(LIES[lie])
    assert watch.lied and not believed[-100:].any()
    assert lie != "jump" or watch.messages[-1][0] < 2.3, "before a slow leaf could have come there"
    assert sum("not believed" in words for _, words in watch.messages) == 1


def test_a_leaf_beyond_the_end_of_its_joint_is_a_lie_before_anything_touches_it():
    watch, believed = flight(lambda time, angle: DOOR.upper_limit + 0.5, duration=0.5)
    assert watch.lied and not believed[-10:].any()


def test_a_single_wild_reading_is_left_out():
    watch, believed = flight(lambda time, angle: angle + (0.3 if 2.0 < time < 2.015 else 0.0))
    assert 1 <= (~believed).sum() <= 3 and not watch.lied and believed[-1]


def test_readings_beside_the_tip_now_and_then_are_no_lie():
    """Each time for less than a lie lasts: by a pose that comes late."""
    aside = math.radians(2.0)
    watch, believed = flight(lambda time, angle: angle + (aside if time > 1.5 and time % 0.5 < 0.06 else 0.0))
    assert not watch.lied and believed[-1] and believed.mean() > 0.9
    watch, _ = flight(lambda time, angle: angle + (aside if time > 1.5 and time % 0.5 < 0.2 else 0.0))
    assert watch.lied


def test_one_that_ends_is_told_and_one_that_comes_back_is_believed():
    watch, believed = flight(lambda time, angle: None if 2.0 < time < 3.0 else angle)
    assert believed[-1] and not watch.lied
    assert [words for _, words in watch.messages if "any more" in words] == ["the leaf is not measured any more"]


def test_a_leaf_that_runs_ahead_of_the_tip_is_a_gap_and_no_lie():
    watch, believed = flight(lambda time, angle: angle - 0.1 * max(time - 2.0, 0.0))
    assert believed.all() and not watch.lied


def frame_at(position, yaw, time=0.0) -> FrameReading:
    return FrameReading(np.array(position), yaw, time, 0.002, 0.01)


def test_a_frame_moves_the_door_within_its_search():
    watch = DoorWatch(MODEL)
    assert watch.moves(None) is None
    offset, yaw = watch.moves(frame_at((0.03, -0.02, 0.0), 0.0))
    np.testing.assert_allclose(offset, (0.03, -0.02), atol=1e-12)
    assert yaw == 0.0 and watch.moves(frame_at((0.03, -0.02, 0.0), 0.0)) is None  # the same once more
    assert watch.moves(frame_at((0.3, 0.0, 0.0), 0.0, 1.0)) is None and "30 cm" in watch.refused
    assert watch.moves(frame_at((0.0, 0.0, 0.0), 0.3, 2.0)) is None
