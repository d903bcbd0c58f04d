r"""How an emulated servo turns to its goal position: ever slower, and never faster than its profile allows.

.. math::
    r = \operatorname{clip}(k\,(p_\text{goal} - p),\ \pm r_\text{max})
"""

from __future__ import annotations

import math

from doorman.rig.emulators.servos.memory import ServoMemory
from doorman.rig.emulators.servos.table import (
    CURRENT_BASED_POSITION_MODE,
    EXTENDED_POSITION_MODE,
    POSITION_MODE,
    RATE_UNIT,
    TICKS_PER_TURN,
)

POSITION_MODES = frozenset((POSITION_MODE, EXTENDED_POSITION_MODE, CURRENT_BASED_POSITION_MODE))
STIFFNESS = 10.0
"""k: slow beside the lag of the joints, so that they do not overshoot [1/s]."""
TIME_BASED = 0x04
"""Bit of the drive mode that makes times of the profile's rows."""


def position_rate(memory: ServoMemory) -> float:
    """Rate towards the goal position, in the sign in which the servo counts."""
    distance = (memory.get("goal position") - memory.get("present position")) * 2.0 * math.pi / TICKS_PER_TURN
    fastest = memory.get("velocity limit")
    profile = memory.get("profile velocity")
    if profile and not memory.get("drive mode") & TIME_BASED:
        fastest = min(fastest, profile)
    return max(-fastest * RATE_UNIT, min(STIFFNESS * distance, fastest * RATE_UNIT))
