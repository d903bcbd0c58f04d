r"""How far the commanded pitch may lead a vehicle whose grip is young.

The attitude loop answers an error θ of the pitch with the torque :math:`I_{yy} K \theta`, and the tied tip resists that turn. An
arm with mass makes :math:`I_{yy}` larger, and its static moment takes its share of the rotors: a lead that they cannot answer
while they lift the weight lets the vehicle sink. So its lead is that share of the settings which the rotors answer.
"""

from __future__ import annotations

import numpy as np

from doorman.kinematics.vehicles.balance import balance_of
from doorman.model import Model

_LEAST_SHARE = 0.2
"""Of the settings: a vehicle whose rotors have less left still has to turn."""


class Engagement:
    """Lead of the commanded pitch after the grip.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        settings, share = model.scenario.control, _share(model)
        self._pitch, self._rate = share * settings.engage_pitch, share * settings.engage_rate

    def lead(self, time: float) -> float:
        """Largest difference of commanded and measured pitch."""
        return self._pitch + self._rate * time


def _share(model: Model) -> float:
    """Of the settings, at most 1."""
    balance = balance_of(model.vehicle)
    if balance is None:
        return 1.0
    settings, pushes = model.scenario.control, model.goal_angle < model.start_angle
    nose_down = np.array([-1.0 if pushes else 1.0, 0.0])
    room = balance.room_towards(model.vehicle.center_of_mass(model.start_arm), nose_down)
    torque = model.vehicle.weight * room
    inertia = float(model.vehicle.inertia(model.start_arm)[1, 1])
    answered = torque / (inertia * model.attitude_loop.stiffness)
    return min(max(answered / settings.engage_pitch, _LEAST_SHARE), 1.0)
