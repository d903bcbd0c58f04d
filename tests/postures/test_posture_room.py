"""Distances of a posture from what bounds it: against Pinocchio, and their slopes against differences."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from finite_differences import central_difference
from postures_of import width
from urdf_variants import write_arm_of

from doorman.model import Model
from doorman.postures.room import Room
from doorman.scenario import Scenario


def room_of(model: Model, **options: Any) -> Room:
    return Room(model.vehicle, model.door, model.reduced, model.scenario.planner.margin, **options)


@pytest.mark.parametrize("joints", [1, pytest.param(3, marks=pytest.mark.slow), 6])
@pytest.mark.parametrize("kind", ["paper", "push"])
def test_distances_and_slopes(tmp_path: Path, joints: int, kind: str) -> None:
    path = write_arm_of(tmp_path / "arm.urdf", joints, odd_axes_seed=joints)
    arms = {"start.arm": [0.0] * joints, "goal.arm": [0.0] * joints}
    model = Model(Scenario.load(kind, {"vehicle.urdf": str(path), "door.width": 3.0, **arms}))
    room, rng = room_of(model, beside=model.contact.beside, mobile=True), np.random.default_rng(joints)
    for _ in range(5):
        state = np.array([0.0, 0.0, *rng.uniform(-1.0, 1.5, 2), 0.0, *rng.uniform(-1.7, 1.7, joints)])
        assert room.width(state) == pytest.approx(width(model, state), abs=1e-12)
        differences = central_difference(room.distances, state)
        free = [2, *range(5, len(state))]
        np.testing.assert_allclose(room.slopes(state)[:, free], differences[:, free], atol=2e-5)


def test_a_stretched_arm_has_no_mobility(tmp_path: Path) -> None:
    """Three joints of which two turn about −y: with both links in line ahead, none of them moves the tip ahead."""
    model = Model(Scenario.load("paper", {"vehicle.urdf": str(write_arm_of(tmp_path / "arm.urdf", 2))}))
    room, state = room_of(model, mobile=True), np.array(model.start_state)
    state[2], state[5:] = 0.0, [0.0, np.arctan2(0.128, 0.5)]  # the tip straight ahead of joint 2
    assert room.mobility(state) == pytest.approx(0.0, abs=1e-12)
    state[6] += 0.3
    assert room.mobility(state) == pytest.approx(np.hypot(0.128, 0.5) * np.sin(0.3), rel=1e-6)


def test_without_jambs_a_doorway_has_no_sides(model: Model) -> None:
    state = np.array(model.start_state)
    narrow = model.reduced.with_numbers({"door.width": 0.5})
    assert not Room(model.vehicle, model.door, narrow, 0.03).keeps(state)
    assert Room(model.vehicle, model.door, narrow, 0.03, jambs=False).keeps(state)
    state[5:] = [0.0, 1.7, -1.6, 0.0]
    assert not Room(model.vehicle, model.door, narrow, 0.0, jambs=False).keeps(state), "outside a joint's limit"
