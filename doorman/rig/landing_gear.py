r"""Landing gear: what carries the vehicle while it stands, without a shape that could meet the door.

Legs of length l stand on the ground z = 0 as soon as O_B is lower than l:

.. math::
    N = \max(0, k (l - z) - c \dot z), \qquad F = N e_3 - \min(\mu N, c_h |v|) \frac{v}{|v|}, \qquad
    \tau = k_t (R e_3 \times e_3) - c_t \omega

The feet are wide: while they touch, they right the vehicle and keep it from turning.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array


@dataclass(frozen=True)
class LandingGear:
    length: float  # l, height of O_B above the ground at which the feet touch [m]
    stiffness: float = 3000.0  # k [N/m]
    damping: float = 200.0  # c [N s/m]
    friction: float = 0.8  # μ
    drag: float = 100.0  # c_h, of a foot that slips slowly [N s/m]
    righting: float = 20.0  # k_t [N m/rad]
    turning: float = 1.5  # c_t [N m s/rad]

    def touches(self, height: float) -> bool:
        return height <= self.length

    def wrench(self, position: Array, velocity: Array, up: Array, spin: Array) -> tuple[Array, Array]:
        deflection = self.length - float(position[2])
        load = max(0.0, self.stiffness * deflection - self.damping * float(velocity[2])) if deflection > 0.0 else 0.0
        if load == 0.0:
            return np.zeros(3), np.zeros(3)
        sliding = math.hypot(float(velocity[0]), float(velocity[1]))
        held = min(self.friction * load, self.drag * sliding) / max(sliding, 1e-9)
        force = np.array([-held * velocity[0], -held * velocity[1], load])
        righting = self.righting * np.array([up[1], -up[0], 0.0])
        return force, righting - self.turning * spin
