r"""Whether an autopilot steers by the attitude commanded to it, or is on its way there.

An autopilot may shape its command: ArduCopter's target follows a step with `ATC_INPUT_TC`, 0.15 s, and is heard late. It is
compared with the way from a slow follower to the command,

.. math::
    R_s \leftarrow R_s \exp\left((1 - e^{-\Delta t / \tau}) \log(R_s^T R)\right)

so that one that is as fast as the follower, or faster, obeys.
"""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world

SHAPING = 0.2
"""Time constant of the slowest autopilot that obeys, the delay of telemetry included [s]."""


class Obedience:
    """Follows the attitude that an autopilot is commanded."""

    def __init__(self) -> None:
        self._commanded: Array | None = None
        self._followed = np.eye(3)
        self._last = -math.inf

    def forget(self) -> None:
        self._commanded = None

    def follow(self, commanded: Array, now: float) -> None:
        rotation = rotation_body_to_world(commanded)
        if self._commanded is None:
            self._followed = rotation
        else:
            share = 1.0 - math.exp(-max(now - self._last, 0.0) / SHAPING)
            self._followed = self._followed @ pin.exp3(share * pin.log3(self._followed.T @ rotation))
        self._commanded, self._last = rotation, now

    def angle(self, steered: Array) -> float:
        if self._commanded is None:
            return math.nan
        off = pin.log3(self._commanded.T @ rotation_body_to_world(steered))
        behind = pin.log3(self._commanded.T @ self._followed)
        length = float(behind @ behind)
        share = min(max(float(off @ behind) / length, 0.0), 1.0) if length > 0.0 else 0.0
        return float(np.linalg.norm(off - share * behind))
