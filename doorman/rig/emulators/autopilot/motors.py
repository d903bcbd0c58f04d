r"""What motors make of the normalised thrust that an emulated autopilot asks its mixer for.

.. math::
    \tau = k u^2 + (1 - k)\,u, \qquad \frac{f}{f_{max}} = u^2

for the signal u of motors whose thrust is its square, as that of propellers is, and with k of PX4's `THR_MDL_FAC` or
ArduPilot's `MOT_THST_EXPO`. At k = 0 the autopilot takes the signal for the thrust, at k = 1 it linearises the motors. Sources:
PX4, parameter reference; ArduPilot, `AP_MotorsMulticopter::apply_thrust_curve_and_volt_scaling`.
"""

from __future__ import annotations

import math
from typing import Literal

MotorKind = Literal["linear", "quadratic"]
"""Motors that the autopilot linearises, whatever its parameter says; or whose thrust is the signal squared."""


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


def normalised_thrust(share: float, k: float) -> float:
    """τ of a share of the largest thrust, the inverse of `thrust_share`.

    Args:
        share: f/f_max, 0 … 1.
        k: Of the autopilot's parameter, 0 … 1.
    """
    return k * share + (1.0 - k) * math.sqrt(share)
