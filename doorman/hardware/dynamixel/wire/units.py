r"""Units of a servo's registers in SI, and its encoder in the URDF's joint angle.

.. math::
    \eta = s\,(p - p_0)\,\frac{2\pi}{4096}

p is the present position, p₀ the one at the joint's zero, s = ±1 the direction. Source of the units: ROBOTIS e-Manual, XH430.
"""

from __future__ import annotations

import math
from types import MappingProxyType

TICKS_PER_TURN = 4096
CENTRE = 2048
"""Tick in the middle of the turn."""
RADIANS_PER_TICK = 2.0 * math.pi / TICKS_PER_TURN
VELOCITY_UNIT = 0.229 * 2.0 * math.pi / 60.0
"""One count of a velocity, 0.229 rev/min [rad/s]."""
CURRENT_UNITS = MappingProxyType({1000: 2.69e-3, 1010: 2.69e-3, 1040: 1.34e-3, 1050: 1.34e-3})
"""One count of a current by model number [A]: the models for 24 V have another sensor."""
VOLTAGE_UNIT = 0.1
"""One count of a voltage [V]."""
TICK_UNIT = 1e-3
"""One count of the servo's clock [s]."""
TICK_RANGE = 32_768
"""The servo's clock starts again at zero here."""
WATCHDOG_UNIT = 0.02
"""One count of the bus watchdog [s]."""
RETURN_DELAY_UNIT = 2e-6
"""One count of the return delay time [s]."""


def joint_angle(position: int, zero: int, direction: int) -> float:
    """Joint angle η at a present position, before whole turns are added."""
    return direction * (position - zero) * RADIANS_PER_TICK


def zero_position(position: int, angle: float, direction: int) -> int:
    """Present position at the joint's zero, from one reading at a known angle.

    Args:
        position: Present position at that angle [tick].
        angle: Of the joint, as the URDF counts it [rad].
        direction: +1 where the servo's positive direction is the joint's, else −1.

    Returns:
        [tick].
    """
    return position - direction * round(angle / RADIANS_PER_TICK)


def whole_turns(angle: float, lower: float, upper: float) -> float:
    """Turns to add to an angle so that it lies between the joint's limits, or as near to them as it can."""
    # After power-on a servo knows its angle only within one turn; the joint's limits tell which one.
    turn = 2.0 * math.pi
    nearest = round(((lower + upper) / 2.0 - angle) / turn) if math.isfinite(lower + upper) else 0
    excess = {k: max(lower - angle - k * turn, angle + k * turn - upper, 0.0) for k in (0, nearest)}
    return turn * min(excess, key=lambda k: (excess[k], abs(k)))
