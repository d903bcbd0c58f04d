"""Turning by the door: a gripping tip takes a force along the leaf, which does not move the door but turns the vehicle.

Rotors turn a vehicle by their drag alone, with a few tenths of a newton metre, and the force that opens a heavy door turns it
back by as much. The same tip, half a metre before the body, turns it by that with a newton to the side.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.rotations import euler_rates
from doorman.model import Model

Array = NDArray[np.float64]

_RATE, _INTEGRAL = 10.0, 30.0
"""Gains from the missing yaw rate to a yaw acceleration, the largest [1/s], [1/s²]."""
_QUICK, _SLOW = 0.18, 0.24
"""Lag of the attitude, by whose tilt the force is made, up to which that goes well, and from which nothing is done [s]. Behind
PX4's 0.3 s the force came when it was not wanted any more, and swung the vehicle about the tip until it fell."""
_FADING = 4.0
"""Time in which the integral fades: what the rotors can do they do themselves [s]."""
_MOST = 0.1
"""Largest force, as a share of the weight."""
_LEAST_LEVER = 0.15
"""With less between tip and body, across the leaf, the force would do too little [m]."""


class TurningAid:
    """Force along the leaf that helps a vehicle with a gripping tip to turn as planned.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        self._coupling, self._door = model.coupling, model.door
        self._inertia = float(model.vehicle.inertia(model.start_arm)[2, 2])
        self._most = _MOST * model.vehicle.weight
        self._integral = 0.0

    def force(
        self, state: Array, body_rates: Array, planned_rate: float, time_step: float, attitude_lag: float
    ) -> Array:
        """Force of the tip on the leaf now, beside the planned one."""
        missing = planned_rate - euler_rates(state[:3], body_rates)[2]
        along = self._door.face(state[3])[0]
        tip = self._coupling.tips(state[None, :3], state[None, 5:])[0]
        lever = float(tip[1] * along[0] - tip[0] * along[1])  # moment about the vertical of the leaf's reaction to 1 N
        most = self._most * abs(lever)
        share = min(max((_SLOW - attitude_lag) / (_SLOW - _QUICK), 0.0), 1.0)
        wanting = missing if share > 0.0 else 0.0  # nothing is wound up meanwhile
        self._integral += time_step * (_INTEGRAL * self._inertia * wanting - self._integral / _FADING)
        self._integral = min(max(self._integral, -most), most)
        if abs(lever) < _LEAST_LEVER:
            return np.zeros(3)
        moment = share * min(max(_RATE * self._inertia * missing + self._integral, -most), most)
        return np.asarray((moment / lever) * along)
