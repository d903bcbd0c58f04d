r"""Forces of the air on the moving vehicle, and of a wall beside its rotors.

.. math::
    F = -c\,(v - (v^T z_B)\,z_B) + \sum_i F_w \Big(\frac{R}{d_i}\Big)^2 n_D

The first is the rotors' drag in their plane (Faessler, Franchi and Scaramuzza, IEEE RA-L 3, 2018, who measured c/m of 0.4 to
0.55 1/s), for the velocity v against still air. The second draws every rotor whose hub is d_i before the leaf's plane towards the
leaf: it falls as the velocity of an image behind the wall, and is F_w where the blade tip touches. Nothing acts on the leaf.
"""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.model import Model
from doorman.simulation.plant.plant import Plant
from doorman.simulation.reality.true_thrust import rotor_radius


class Drag:
    """Forces of one flight, at the origin of the free body."""

    def __init__(self, model: Model, plant: Plant, layout: RotorLayout) -> None:
        simulation = model.scenario.simulation
        self._drag, self._wall = simulation.vehicle_drag, simulation.wash.wall
        self._radius, self._door, self._plant = rotor_radius(model, layout), model.true_door, plant
        self._sites = [plant.engine_model.site(f"rotor_{index + 1}").id for index in range(layout.count)]
        self._up = plant.data.xmat[plant.base_body].reshape(3, 3)[:, 2]
        self._places, self._velocity = plant.data.site_xpos, plant.data.qvel[:3]
        self._applied = plant.data.qfrc_applied[:3]

    def act(self) -> None:
        """Set this step's force."""
        velocity = self._velocity
        self._applied[:] = -self._drag * (velocity - (velocity @ self._up) * self._up)
        if self._wall > 0.0:
            angle = self._plant.door_angle
            self._applied += wall_force(self._door, angle, self._places[self._sites], self._radius, self._wall)


def wall_force(door: Door, door_angle: float, rotors: Array, radius: float, most: float) -> Array:
    """Force of the leaf's plane on rotors before it, shape (3,), world frame [N]."""
    normal, away = door.normal(door_angle), rotors - door.hinge_position
    distances, along = -away @ normal, away @ door.leaf_direction(door_angle)
    beside = (distances > 0.0) & (along >= 0.0) & (along <= door.width)
    near = radius / np.maximum(distances, radius)
    return np.asarray(most * float((near[beside] ** 2).sum()) * normal)
