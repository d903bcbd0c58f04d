"""A gripper that holds feels its pull and stays where it is, a loose one does neither: the watch by itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from urdf_variants import DOOR, write_edited

from doorman import Model
from doorman.gravity import GRAVITY
from doorman.mission.grip_watch import TUG, GripWatch, _Sums
from doorman.scenario import Scenario

TICK = 0.004
THERE = (0.1, -0.05)
"""Place of the tip on the leaf [m]."""


def test_the_variance_of_a_window_that_moves_is_numpys() -> None:
    rng, sums = np.random.default_rng(3), _Sums()
    values = 1e3 + np.cumsum(rng.standard_normal(3000))
    for k, value in enumerate(values.tolist()):
        sums.add(value)
        if k >= 200:
            sums.remove(float(values[k - 200]))
            assert sums.variance(200) == pytest.approx(np.var(values[k - 199 : k + 1]), rel=1e-9)


def first_alarm(
    model: Model,
    push: Callable[[float], float],
    felt: float,
    noise: float = 0.05,
    bias: float = 0.0,
    seconds: float = 6.0,
) -> float | None:
    """When the watch says that the gripper is loose, of which the leaf takes a share `felt` of the push [s]."""
    watch, rng, poles = GripWatch(model), np.random.default_rng(5), [0.0] * 3
    for k in range(round(seconds / TICK)):
        before = felt * push(k * TICK)
        for pole in range(3):  # as the vehicle's observer estimates it
            poles[pole] += (1.0 - math.exp(-15.0 * TICK)) * (before - poles[pole])
            before = poles[pole]
        force = before + bias + noise * rng.standard_normal()
        known = SimpleNamespace(push=push(k * TICK), normal_force=force, tip_angle=math.pi / 2)
        if watch.is_loose(known, THERE, True, True, TICK):  # type: ignore[arg-type]
            return k * TICK
    return None


def swinging(time: float) -> float:
    return 4.0 * math.sin(2.0 * time)


@pytest.mark.parametrize("felt", [0.5, 0.78, 1.0])
@pytest.mark.parametrize("resisted", [0.0, 1.5, -1.5])
def test_a_leaf_that_takes_its_share_is_held(model: Model, felt: float, resisted: float) -> None:
    """Whatever the hinge takes besides: friction may take all of a pull that brakes the door."""
    assert first_alarm(model, swinging, felt, noise=0.2, bias=resisted) is None


@pytest.mark.parametrize("bias", [0.0, 0.2, -0.2])
def test_a_loose_tip_is_noticed_by_a_tug_within_a_second(model: Model, bias: float) -> None:
    tug = TUG * model.vehicle.mass * GRAVITY
    alarm = first_alarm(model, lambda time: -tug * min(time / 0.2, 1.0), 0.0, bias=bias)
    assert alarm is not None and alarm < 0.8


def test_a_loose_tip_that_follows_a_plan_is_noticed(model: Model) -> None:
    alarm = first_alarm(model, swinging, 0.0)
    assert alarm is not None and alarm < 1.0


def test_who_neither_pushes_nor_pulls_learns_nothing(model: Model) -> None:
    assert first_alarm(model, lambda time: 0.1 * math.sin(5.0 * time), 0.0) is None


def test_an_open_gripper_is_not_looked_at(model: Model) -> None:
    watch = GripWatch(model)
    known = SimpleNamespace(push=-3.0, normal_force=0.0, tip_angle=math.pi / 2)
    assert not any(watch.is_loose(known, THERE, False, False, TICK) for _ in range(1000))  # type: ignore[arg-type]


def test_what_was_felt_before_a_slip_is_forgotten(model: Model) -> None:
    """A leaf that was pushed hard and outran the tip: from then on a loose tip brakes and is not felt."""
    watch, slipped, rng, poles = GripWatch(model), 2.0, np.random.default_rng(2), [0.0] * 3
    for k in range(1000):
        time = k * TICK
        since = max(time - slipped, 0.0)
        push = 5.0 * math.sin(min(time, 1.5)) * math.exp(-since / 0.2) - 1.5 * math.sin(5.0 * since)
        felt = 0.8 * push if time < slipped else 0.0
        for pole in range(3):
            poles[pole] += (1.0 - math.exp(-15.0 * TICK)) * (felt - poles[pole])
            felt = poles[pole]
        known = SimpleNamespace(push=push, normal_force=felt + 0.05 * rng.standard_normal(), tip_angle=1.2)
        if watch.is_loose(known, THERE, True, True, TICK):  # type: ignore[arg-type]
            assert slipped < time < slipped + 1.2
            return
    pytest.fail("it was not noticed")


@pytest.mark.parametrize(
    ("gripped", "back", "loose"), [(0.0, 0.01, False), (0.0, 0.02, True), (0.02, 0.03, False), (0.02, 0.04, True)]
)
def test_a_closed_leaf_does_not_come_back_through_its_stop(
    model: Model, gripped: float, back: float, loose: bool
) -> None:
    """In metres behind where the map has the closed leaf: at the grip, and later."""
    watch, lever = GripWatch(model), model.coupling.distance_from_hinge
    found = False
    for k in range(100):
        behind = gripped if k < 20 else back
        known = SimpleNamespace(push=0.0, normal_force=0.0, tip_angle=math.pi / 2 + behind / lever)
        found |= watch.is_loose(known, THERE, True, True, TICK)  # type: ignore[arg-type]
    assert found is loose


@pytest.mark.parametrize(("stop", "loose"), [(1.6, True), (1.7, False)])
def test_the_stop_is_where_the_joint_ends(stop: float, loose: bool, tmp_path: Path) -> None:
    """A leaf that begins beyond closed, at the end of its joint or before it, and is pulled back by 2 cm."""
    door = write_edited(tmp_path / "door.urdf", DOOR, ('upper="1.5708"', f'upper="{stop}"'))
    model = Model(Scenario.load("paper", {"door.urdf": str(door), "contact.side": "push", "start.door_angle": 1.6}))
    watch, angle = GripWatch(model), 1.6 + 0.02 / model.coupling.lever_length
    known = SimpleNamespace(push=0.0, normal_force=0.0, tip_angle=1.6)
    assert not any(watch.is_loose(known, THERE, True, True, TICK) for _ in range(50))  # type: ignore[arg-type]
    known.tip_angle = angle
    assert loose is any(watch.is_loose(known, THERE, True, True, TICK) for _ in range(100))  # type: ignore[arg-type]


def test_a_leaf_that_begins_open_may_come_back() -> None:
    ajar = Model(Scenario.load("paper", {"start.door_angle": math.pi / 2 - 0.3}))
    watch = GripWatch(ajar)
    known = SimpleNamespace(push=0.0, normal_force=0.0, tip_angle=math.pi / 2 + 0.1)
    assert not any(watch.is_loose(known, THERE, True, True, TICK) for _ in range(200))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("moved", "within"),
    [
        (lambda time: 0.5 * time, 0.15),  # comes off, as a vehicle turns about its own centre
        (lambda time: -0.3 * time, 0.2),
        (lambda time: 0.018 * time, None),  # creeps, about a hinge that is 3 cm from its place in the map
        (lambda time: 0.04 if time < 0.03 else 0.0, None),  # seems to jump, as a gap in the poses ends
        (lambda time: 0.012 * math.sin(30.0 * time), None),  # is noisy
        (lambda time: 0.05, None),  # jumps with the frame of the poses
    ],
)
@pytest.mark.parametrize("axis", [0, 1])
def test_a_tip_that_leaves_its_place_on_the_leaf_is_loose(
    model: Model, moved: Callable[[float], float], within: float | None, axis: int
) -> None:
    watch, known, noticed = GripWatch(model), SimpleNamespace(push=0.0, normal_force=0.0, tip_angle=1.2), None
    for k in range(600):
        place = list(THERE)
        place[axis] += moved(k * TICK - 1.0) if k * TICK >= 1.0 else 0.0
        if noticed is None and watch.is_loose(known, (place[0], place[1]), True, True, TICK):  # type: ignore[arg-type]
            noticed = k * TICK - 1.0
    assert (noticed is None) is (within is None)
    assert noticed is None or within is None or 0.05 < noticed < within


def test_the_place_counts_from_when_the_gripper_holds(model: Model) -> None:
    watch, known = GripWatch(model), SimpleNamespace(push=0.0, normal_force=0.0, tip_angle=1.2)
    for k in range(300):
        held = k >= 100
        assert not watch.is_loose(known, THERE if held else (0.3, 0.2), True, held, TICK)  # type: ignore[arg-type]
