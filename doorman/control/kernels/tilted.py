"""Kernel of an attitude with the same direction of thrust at another heading."""

from __future__ import annotations

import math

from doorman.compilation import kernel


@kernel
def tilted(roll: float, pitch: float, yaw: float) -> tuple[float, float]:
    """Roll and pitch, at a heading, that give the thrust the direction of [roll, pitch, 0]."""
    x, y, up = math.sin(pitch) * math.cos(roll), -math.sin(roll), math.cos(pitch) * math.cos(roll)
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, aside = c * x + s * y, -s * x + c * y
    return -math.asin(min(max(aside, -1.0), 1.0)), math.atan2(ahead, up)
