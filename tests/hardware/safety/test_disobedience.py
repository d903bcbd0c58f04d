"""An autopilot that steers elsewhere than it was told, while the gripper holds on to the door."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from doorman.hardware.pixhawk import EventKind, Timeouts, VehicleSample
from doorman.hardware.safety import RULES
from doorman.hardware.safety.consistency import Obedience
from doorman.hardware.safety.observer import Observer
from doorman.hardware.safety.rules import Fault
from doorman.scenario import SafetySection

TOLD = np.array([0.1, -0.05, 2.0])
LIMIT = SafetySection().disobedience
PATIENCE = next(rule.patience for rule in RULES if rule.fault is Fault.DISOBEDIENCE)
LOOK = 0.02
"""Time between two looks of the supervisor [s]."""


def seen(
    target: np.ndarray, age: float = 0.05, holding: bool = True, setpoints: str = "attitude", told=TOLD,
    conditions: frozenset[EventKind] = frozenset(),
) -> float:  # fmt: skip
    links = SimpleNamespace(holding=holding, config=SimpleNamespace(pixhawk=SimpleNamespace(setpoints=setpoints)))
    observer = Observer.__new__(Observer)
    observer._backend = SimpleNamespace(links=links, commanding=True, attitude=told)
    observer._obedience, observer._stale = Obedience(), Timeouts.state
    sample = VehicleSample(attitude_target=target, thrust_target_time=10.0 - age)
    return observer._disobedience(sample, conditions, 10.0)


@pytest.mark.parametrize("turn", [[0.0, 0.0, 0.0], [0.25, 0.0, 0.0], [0.0, -0.3, 0.0], [0.0, 0.0, 0.4]])
def test_angle_between_what_was_told_and_what_is_steered_by(turn):
    assert seen(TOLD + turn) == pytest.approx(float(np.abs(turn).max()), abs=0.02)


def test_a_turn_of_the_yaw_by_a_whole_circle_is_none():
    assert seen(TOLD + [0.0, 0.0, 2.0 * math.pi]) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    "why",
    [{"holding": False}, {"setpoints": "position"}, {"age": 1.0}, {"told": np.full(3, math.nan)},
     {"conditions": frozenset({EventKind.SETPOINT_STALE})}],
)  # fmt: skip
def test_nothing_is_said_without_a_grip_a_fresh_command_or_a_fresh_target(why):
    assert math.isnan(seen(TOLD + [0.5, 0.0, 0.0], **why))
    assert math.isnan(seen(np.full(3, math.nan)))


def longest(told, steered, until: float = 3.0) -> float:
    """Longest time for which the autopilot steers farther off than is allowed, looked at as the supervisor does [s]."""
    obedience, since, most = Obedience(), math.inf, 0.0
    for time in np.arange(0.0, until, LOOK):
        obedience.follow(told(time), time)
        off = obedience.angle(steered(time)) > LIMIT
        since = min(since, time) if off else math.inf
        most = max(most, time - since)
    return most


def giving_way(time: float) -> np.ndarray:
    """From pulling at the leaf to giving way to it, as steeply as that tilts, from one tick to the next."""
    return np.array([0.0, -0.1, -1.1]) if time < 1.0 else np.array([0.34, 0.34, -1.1])


@pytest.mark.parametrize("lag", [0.0, 0.15, 0.25])
@pytest.mark.parametrize("delay", [0.0, 0.05, 0.1])
def test_an_autopilot_that_shapes_a_step_obeys(lag, delay):
    """ArduCopter's is 0.15 s, and its telemetry late by up to 0.1 s."""

    def steered(time: float) -> np.ndarray:
        since = time - 1.0 - delay
        share = 0.0 if since < 0.0 else 1.0 if lag == 0.0 else 1.0 - math.exp(-since / lag)
        return (1.0 - share) * giving_way(0.0) + share * giving_way(2.0)

    assert longest(giving_way, steered) < 0.5 * PATIENCE


@pytest.mark.parametrize("stuck", [[0.0, -0.1, -1.1], [0.0, 0.0, -1.1], [-0.1, -0.2, -1.1]])
def test_an_autopilot_that_does_not_hear_a_step_disobeys(stuck):
    assert longest(giving_way, lambda time: np.array(stuck)) > PATIENCE + 1.0


def test_an_autopilot_that_levels_as_it_is_told_to_pull_ever_harder_disobeys():
    """Commands lost: the plan leans further as the door does not come."""

    def told(time: float) -> np.ndarray:
        return np.array([0.0, -0.1 - 0.3 * time, -1.1])

    assert longest(told, lambda time: np.array([0.0, 0.0, -1.1]), until=1.2) > PATIENCE


def test_a_follower_that_was_forgotten_begins_anew():
    obedience = Obedience()
    obedience.follow(giving_way(0.0), 0.0)
    obedience.forget()
    obedience.follow(giving_way(2.0), 0.02)
    assert obedience.angle(giving_way(0.0)) > LIMIT
