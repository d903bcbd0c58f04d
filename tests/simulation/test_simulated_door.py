"""The door alone, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.simulation import Disturbance

INERTIA = 5.28


def loose(flight, hinge_torque=0.0, **overrides):
    """A door that nobody touches."""
    source = (lambda time: Disturbance(hinge_torque=hinge_torque)) if hinge_torque else None
    return flight(contact__kind="push", away=True, disturbance=source, **overrides)


def test_rate_decays_by_the_damping(flight):
    door = loose(flight, simulation__door_damping=4.0)
    door.data.qvel[door.plant.hinge_velocity] = -1.0
    for truth in door.run(2.0, every=100):
        assert truth.door_rate == pytest.approx(-math.exp(-4.0 / INERTIA * truth.time), rel=2e-3)
        travelled = INERTIA / 4.0 * (1.0 - math.exp(-4.0 / INERTIA * truth.time))
        assert truth.door_angle == pytest.approx(math.pi / 2 - travelled, abs=1e-3)


def test_friction_holds_below_and_slides_above(flight):
    held = loose(flight, hinge_torque=-1.5, simulation__door_friction=2.0).run(2.0, every=2000)[-1]
    assert abs(held.door_angle - math.pi / 2) < 1e-4 and abs(held.door_rate) < 1e-4
    end = loose(flight, hinge_torque=-2.5, simulation__door_friction=2.0).run(1.0, every=1000)[-1]
    assert end.door_rate == pytest.approx(-0.5 / INERTIA, rel=0.01)


def test_spring_swings_at_its_frequency(flight):
    door = loose(flight, door__stiffness=20.0, door__rest_angle=1.0)
    omega = math.sqrt(20.0 / INERTIA)
    for truth in door.run(2.0, every=50):
        expected = 1.0 + (math.pi / 2 - 1.0) * math.cos(omega * truth.time)
        assert truth.door_angle == pytest.approx(expected, abs=3e-3)


def test_a_door_that_is_slammed_stops_within_a_degree_and_is_not_thrown_back(flight):
    door = loose(flight, start__door_angle=1.2)
    door.data.qvel[door.plant.hinge_velocity] = 2.0
    truths = door.run(1.0)
    assert max(truth.door_angle for truth in truths) == pytest.approx(
        math.pi / 2 + math.radians(0.8), abs=math.radians(0.3)
    )
    assert min(truth.door_rate for truth in truths) > -0.3
    assert truths[-1].door_angle < math.pi / 2 + math.radians(0.1)


def test_an_open_door_stops_at_the_urdfs_other_limit(flight):
    end = loose(flight, hinge_torque=-8.0, start__door_angle=0.0, simulation__door_damping=5.0).run(4.0, every=4000)[-1]
    assert end.door_angle == pytest.approx(-1.5, abs=0.01)
    assert np.isfinite(end.door_rate)
