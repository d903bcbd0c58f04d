r"""Centre of mass and inertia of vehicle and arm in CasADi symbols; Pinocchio's numbers are the check of them.

With the frames :math:`R_i, p_i` of `symbols.arm_frames` and the masses of `Bodies`:
:math:`c_i = p_i + R_i o_i`, :math:`c = \tfrac1m\sum m_i c_i`,
:math:`I = \sum R_i I_i R_i^T + m_i\big(r_i^T r_i - r_i r_i^T\big)` about c with :math:`r_i = c_i - c`.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.kinematics.symbols import arm_frames
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern


class SymbolicBodies:
    """What the bodies make together, in the body frame: of the pattern's symbols (k, 1), H (n, 1) and `Bodies.numbers`."""

    def __init__(self, pattern: ArmPattern, arm: Any, angles: Any, bodies: Any) -> None:
        self._rotations, places = arm_frames(pattern, arm, angles)
        self._masses, self._inertias = ca.vertsplit(bodies.masses), bodies.inertias
        offsets = [bodies.centers[3 * i : 3 * i + 3] for i in range(len(places))]
        self._centers = [
            place + turn @ offset for place, turn, offset in zip(places, self._rotations, offsets, strict=True)
        ]
        moments = [mass * center for mass, center in zip(self._masses, self._centers, strict=True)]
        self.center: Any = sum(moments[1:], moments[0]) / sum(self._masses[1:], self._masses[0])
        """c, (3, 1) [m]."""

    def inertia(self) -> Any:
        """I about c in body axes, (3, 3) [kg m²]."""
        total = ca.SX.zeros(3, 3)
        for i, (turn, mass, center) in enumerate(zip(self._rotations, self._masses, self._centers, strict=True)):
            away = center - self.center
            own = symmetric(self._inertias[6 * i : 6 * i + 6])
            total += turn @ own @ turn.T + mass * (ca.dot(away, away) * ca.SX.eye(3) - away @ away.T)
        return total


def symmetric(six: Any) -> Any:
    """Symmetric matrix from its six entries."""
    xx, xy, xz, yy, yz, zz = ca.vertsplit(six)
    return ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))
