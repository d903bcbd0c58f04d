r"""Thrust as the rotors truly make it of their set points: by a scale, less as the battery empties, more near floor and ceiling.

.. math::
    T = k\,e^{-\lambda t}\,\frac{1}{1-(R/4z)^2}\,\gamma^{2/3}\,T_{set}, \qquad
    \gamma = \tfrac12 + \tfrac12\sqrt{1 + \tfrac18 (R/d)^2}

for a rotor of radius R at the height z above the floor and d below a ceiling, at constant power. The floor's factor is that of
Cheeseman and Bennett (ARC R&M 3021, 1955), the ceiling's that of Hsiao and Chirarattananon (IEEE/ASME Trans. Mechatronics 24,
2019). The drag torque goes with the thrust. Every rotor counts by itself: a shared cushion of air is not modelled, nor is what
the air does between frame and leaf.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.model import Model
from doorman.scenario import SimulationSection
from doorman.simulation.plant.plant import Plant

_NEAREST = 0.5
"""Rotors count as no nearer to floor and ceiling than this share of their radius: below it neither model was measured."""


class TrueThrust:
    """Gears of one plant's rotors."""

    def __init__(self, simulation: SimulationSection, plant: Plant, layout: RotorLayout, radius: float) -> None:
        self._scale, self._fall, self._wash = simulation.thrust_scale, simulation.thrust_fall, simulation.wash
        self._radius, self._layout = radius, layout
        self._sites = [plant.engine_model.site(f"rotor_{index + 1}").id for index in range(layout.count)]
        self._places = plant.data.site_xpos
        self._gears = plant.engine_model.actuator_gear
        self._torques = np.array(self._gears[: layout.count, 5])
        self.act(0.0)

    def turn(self, directions: Array) -> None:
        """Rotors that turn otherwise than the URDF says."""
        self._torques = -directions * self._layout.torque_per_thrust

    def act(self, time: float) -> None:
        """Set the thrust of this step."""
        gain = self._scale * math.exp(-self._fall * time) * self._nearness()
        self._gears[: self._layout.count, 2] = gain
        self._gears[: self._layout.count, 5] = gain * self._torques

    def _nearness(self) -> Array:
        """Factor of floor and ceiling, shape (m,)."""
        factor = np.ones(self._layout.count)
        if not self._wash.ground and self._wash.ceiling is None:
            return factor
        heights, least = self._places[self._sites, 2], _NEAREST * self._radius
        if self._wash.ground:
            factor *= ground_effect(self._radius / np.maximum(heights, least))
        if self._wash.ceiling is not None:
            factor *= ceiling_effect(self._radius / np.maximum(self._wash.ceiling - heights, least))
        return factor


def ground_effect(nearness: Array) -> Array:
    """Share of the thrust in free air that a rotor makes near the floor, at the same power."""
    return np.asarray(1.0 / (1.0 - (nearness / 4.0) ** 2))


def ceiling_effect(nearness: Array) -> Array:
    """Share of the thrust in free air that a rotor makes near the ceiling, at the same power."""
    return np.asarray((0.5 + 0.5 * np.sqrt(1.0 + nearness**2 / 8.0)) ** (2.0 / 3.0))


def true_thrust(model: Model, plant: Plant, layout: RotorLayout) -> TrueThrust | None:
    """The true thrust, or None where every rotor makes what it is commanded."""
    simulation = model.scenario.simulation
    near = simulation.wash.ground or simulation.wash.ceiling is not None
    if simulation.thrust_scale == 1.0 and simulation.thrust_fall == 0.0 and not near:
        return None
    return TrueThrust(simulation, plant, layout, rotor_radius(model, layout))


def rotor_radius(model: Model, layout: RotorLayout) -> float:
    """Radius of one rotor: what the disc of all rotors leaves around their hubs [m]."""
    return float(model.vehicle.radius - np.hypot(layout.positions[:, 0], layout.positions[:, 1]).max())
