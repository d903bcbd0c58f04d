r"""How far the commanded pitch may lead a vehicle whose grip is young.

The attitude loop answers an error θ of the pitch with the torque :math:`I_{yy} K \theta`, and the tied tip resists that turn. An
arm with mass makes :math:`I_{yy}` larger, and its static moment takes its share of the rotors: a lead that they cannot answer
while they lift the weight lets the vehicle sink. So its lead is that share of the usual one which the rotors answer.
"""

from __future__ import annotations

import numpy as np

from doorman.kinematics.vehicles.balance import balance_of
from doorman.model import Model

ENGAGE_PITCH, ENGAGE_RATE = 0.1, 0.2
"""Largest difference of the commanded and the measured pitch at the start [rad], and its growth per second flown [rad/s]: the
rotors of the shipped vehicle answer that without sinking."""
_LEAST_SHARE = 0.2
"""Of these: a vehicle whose rotors have less left still has to turn."""


class Engagement:
    """Lead of the commanded pitch after the grip.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        share = _share(model)
        self._pitch, self._rate = share * ENGAGE_PITCH, share * ENGAGE_RATE

    def lead(self, time: float) -> float:
        """Largest difference of commanded and measured pitch."""
        return self._pitch + self._rate * time


def _share(model: Model) -> float:
    """Of the settings, at most 1."""
    balance = balance_of(model.vehicle)
    if balance is None:
        return 1.0
    pushes = model.goal_angle < model.start_angle
    nose_down = np.array([-1.0 if pushes else 1.0, 0.0])
    room = balance.room_towards(model.vehicle.center_of_mass(model.start_arm), nose_down)
    torque = model.vehicle.weight * room
    inertia = float(model.vehicle.inertia(model.start_arm)[1, 1])
    answered = torque / (inertia * model.attitude_loop.stiffness)
    return min(max(answered / ENGAGE_PITCH, _LEAST_SHARE), 1.0)
