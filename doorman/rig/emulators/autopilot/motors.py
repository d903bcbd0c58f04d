r"""What motors make of the normalised thrust that an emulated autopilot asks its mixer for.

.. math::
    \tau = k u^2 + (1 - k)\,u, \qquad \frac{f}{f_{max}} = u^2

for the signal u of motors whose thrust is its square, as that of propellers is, and with k of PX4's `THR_MDL_FAC` or
ArduPilot's `MOT_THST_EXPO`: at k = 0 the autopilot takes the signal for the thrust, at k = 1 it linearises the motors. Sources:
PX4, parameter reference; ArduPilot, `AP_MotorsMulticopter::apply_thrust_curve_and_volt_scaling`.
"""

from __future__ import annotations

import math
from typing import Literal

from doorman.rig.emulators.autopilot.parameters import ParameterStore

MotorKind = Literal["linear", "quadratic"]
"""Motors that the autopilot linearises, whatever its parameter says; or whose thrust is the signal squared."""
FACTORS = {"px4": "THR_MDL_FAC", "ardupilot": "MOT_THST_EXPO"}
"""Parameter that holds k."""


class Motors:
    """All motors of one vehicle.

    Args:
        kind: Of the motors.
        factor: Name of the parameter that holds k.
        parameters: Of the autopilot; they may change.
    """

    def __init__(self, kind: MotorKind, factor: str, parameters: ParameterStore) -> None:
        self._kind, self._factor, self._parameters = kind, factor, parameters

    def share(self, normalised: float) -> float:
        """Share of the largest thrust that a normalised thrust becomes, 0 … 1.

        Args:
            normalised: τ, 0 … 1.
        """
        return normalised if self._kind == "linear" else thrust_share(normalised, self._parameters[self._factor])

    def normalised(self, share: float) -> float:
        """Normalised thrust that becomes a share of the largest thrust, 0 … 1.

        Args:
            share: f/f_max, 0 … 1.
        """
        k, u = self._parameters[self._factor], math.sqrt(share)
        return share if self._kind == "linear" else k * u * u + (1.0 - k) * u


def thrust_share(normalised: float, k: float) -> float:
    """f/f_max = u² of motors whose thrust is the signal squared.

    Args:
        normalised: τ, 0 … 1.
        k: Of the autopilot's parameter, 0 … 1.
    """
    if k < 1e-6:
        return normalised * normalised
    u = (math.sqrt((1.0 - k) ** 2 + 4.0 * k * normalised) - (1.0 - k)) / (2.0 * k)
    return u * u
