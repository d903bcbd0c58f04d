"""The door as it truly is, where the planner is told another."""

from __future__ import annotations

import math

import pytest

from doorman.simulation import Disturbance


def loose(flight, **overrides):
    source = lambda time: Disturbance(hinge_torque=-3.0)  # noqa: E731
    return flight(contact__kind="push", away=True, disturbance=source, **overrides)


@pytest.mark.parametrize(
    ("overrides", "inertia"),
    [
        ({"simulation__door_mass": 20.0}, 5.28 * 20.0 / 11.0),
        ({"simulation__door_mass": 8.0, "door__width": 1.4}, 8.0 * 1.4**2 / 3.0),
        ({"door__width": 1.1, "simulation__door_width": 1.3, "simulation__door_mass": 8.0}, 8.0 * 1.3**2 / 3.0),
        ({"door__mass": 8.0}, 8.0 * 1.2**2 / 3.0),
        ({"simulation__door_face_offset": 0.04, "simulation__door_yaw": 0.06}, 5.28 + 11.0 * 0.04**2),
    ],
    ids=["true mass", "true mass, told width", "true mass and width", "told mass", "before the axis"],
)
def test_the_true_leaf_moves(flight, overrides, inertia):
    end = loose(flight, **overrides).run(0.5, every=500)[-1]
    assert -3.0 / (end.door_rate / 0.5) == pytest.approx(inertia, rel=1e-4)


def test_the_true_width_is_met_and_the_told_one_plans(flight):
    door = loose(flight, door__width=1.1, simulation__door_width=1.3)
    assert door.model.reduced.numbers.one("door.width") == door.model.door.width == pytest.approx(1.1)
    lengths = {round(2.0 * float(half), 3) for size in door.plant.engine_model.geom_size for half in size}
    assert 1.3 in lengths and 1.1 not in lengths
    assert loose(flight, simulation__door_mass=20.0).model.door.inertia == pytest.approx(5.28)


@pytest.mark.parametrize(
    ("overrides", "damping", "friction", "stiffness"),
    [
        ({"door__damping": 0.3, "door__friction": 0.4, "door__stiffness": 2.0}, 0.3, 0.4, 2.0),
        ({"door__damping": 0.3, "simulation__door_damping": 0.0, "simulation__door_friction": 0.7}, 0.0, 0.7, 0.0),
        ({"door__stiffness": 2.0, "simulation__door_stiffness": 0.0, "door__damping": 0.3}, 0.3, 0.0, 0.0),
        ({"simulation__door_stiffness": 2.0, "simulation__door_damping": 0.1}, 0.1, 0.0, 2.0),
    ],
)
def test_the_hinges_torques_are_the_true_ones_or_else_the_told_ones(flight, overrides, damping, friction, stiffness):
    plant = flight(contact__kind="push", **overrides).plant
    engine, hinge = plant.engine_model, plant.hinge_velocity
    found = engine.dof_damping[hinge], engine.dof_frictionloss[hinge], engine.jnt_stiffness[engine.dof_jntid[hinge]]
    assert found == (damping, friction, stiffness)
    assert engine.qpos_spring[plant.hinge_position] == pytest.approx(math.pi / 2), "a closer rests where it is told"
