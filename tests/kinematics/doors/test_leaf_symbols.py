"""The leaf in symbols against `Door`, which Pinocchio checks: contact point, face, lever and weight, on joints of all kinds."""

from __future__ import annotations

import math
from types import SimpleNamespace

import casadi as ca
import numpy as np
import pytest
from leaves import LEAVES, write_leaf
from urdf_variants import VEHICLE

from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.leaf.leaf_symbols import VerticalLeaf, leaf_in_symbols
from doorman.kinematics.task_numbers import task_numbers
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.scenario import DoorSection

AWAY, HEIGHT = 0.5, 0.3
TASKS = ["paper", "push_left", "pull", "drawer", "hatch"]


@pytest.fixture(scope="module", params=[*TASKS, *LEAVES])
def door(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Door:
    if request.param in TASKS:
        return Model(request.param).door
    kind = LEAVES[request.param]
    path = write_leaf(tmp_path_factory.mktemp("leaf") / "leaf.urdf", kind)
    return Door(path, DoorSection(closed=kind.closed), "push" if kind.side == "push" else "pull")


def in_symbols(door: Door, angle: float, yaw: float) -> VerticalLeaf:
    """The leaf with numbers in the place of its symbols."""
    numbers = task_numbers(Vehicle(VEHICLE), door, AWAY, HEIGHT)
    groups = {
        group: SimpleNamespace(
            **{name.partition(".")[2]: ca.DM(numbers[name]) for name in numbers.sizes if name.startswith(f"{group}.")}
        )
        for group in ("door", "contact")
    }
    return leaf_in_symbols(groups["door"], groups["contact"], ca.DM(angle), ca.DM(yaw))


def values(expression: object) -> np.ndarray:
    return np.array(ca.DM(expression)).ravel()


def test_a_leaf_in_symbols_is_the_doors_own(door: Door) -> None:
    for angle in (0.4, 1.2, math.pi / 2, 1.9):
        leaf = in_symbols(door, angle, 0.3)
        place = values(leaf.contact_from_hinge)
        np.testing.assert_allclose(door.hinge_position + place, door.contact_point(angle, AWAY, HEIGHT), atol=1e-9)
        np.testing.assert_allclose(values(leaf.normal), door.normal(angle), atol=1e-9)
        np.testing.assert_allclose(values(leaf.leaf_direction), door.leaf_direction(angle), atol=1e-9)
        np.testing.assert_allclose(values(leaf.up), door.up, atol=1e-9)
        np.testing.assert_allclose(values(leaf.lever), door.lever(angle, AWAY), atol=1e-9)
        np.testing.assert_allclose(values(leaf.lever_at(leaf.contact_from_hinge)), door.lever(angle, AWAY), atol=1e-9)
        assert values(leaf.weight_torque) == pytest.approx([door.weight_torque(angle)], abs=1e-6)


def test_any_point_of_the_leaf_moves_by_its_own_lever(door: Door) -> None:
    """A point above the contact and farther from the hinge, by differences of where `Door` has it."""
    step = 1e-6
    before, after = (door.contact_point(1.3 + sign * step, 1.7, -0.4) for sign in (-1.0, 1.0))
    point = 0.5 * (before + after) - door.hinge_position
    lever = in_symbols(door, 1.3, 0.0).lever_at(ca.DM(point))
    np.testing.assert_allclose(values(lever), (after - before) / (2.0 * step), atol=1e-8)
