"""Drag of the rotors and the pull of a wall, by the vehicle's motion and by hand."""

from __future__ import annotations

import math

import numpy as np
from urdf_variants import DOOR

from doorman.kinematics.doors.door import Door
from doorman.simulation.reality.drag import wall_force


def test_a_level_vehicle_slows_down_exponentially_and_falls_freely(flight):
    vehicle = flight(contact__kind="push", away=True, simulation__vehicle_drag=3.0)
    vehicle.data.qvel[:3] = [0.5, -0.2, 0.3]
    velocity = vehicle.run(0.5, every=500)[-1].velocity
    np.testing.assert_allclose(velocity, [0.5 * math.exp(-0.5), -0.2 * math.exp(-0.5), 0.3], atol=0.01)


def test_a_leaf_draws_rotors_before_it():
    door, angle = Door(DOOR), 1.2
    normal, along = door.normal(angle), door.leaf_direction(angle)
    place = lambda distance, side: door.hinge_position + side * along - distance * normal  # noqa: E731
    force = lambda *rotors: wall_force(door, angle, np.array(rotors), 0.1, 0.4)  # noqa: E731
    np.testing.assert_allclose(force(place(0.1, 0.6)), 0.4 * normal)
    np.testing.assert_allclose(force(place(0.2, 0.6), place(0.2, 0.3)), 0.2 * normal)
    assert not force(place(0.2, -0.1), place(-0.2, 0.6), place(0.2, 1.3)).any(), "beside the leaf, or behind it"


def test_a_vehicle_at_the_leaf_drifts_to_it(flight):
    def speed(most: float) -> float:
        vehicle = flight(contact__kind="push", simulation__wash__wall=most)
        vehicle.data.qpos[0] -= 0.05
        return float(vehicle.run(0.2, every=200)[-1].velocity[0])

    assert abs(speed(0.0)) < 1e-3 < 0.01 < speed(1.0)
