r"""Rotations, the arm and what its bodies make together in CasADi symbols; Pinocchio's numbers are the check of them.

:math:`R = R_z(\psi)R_y(\theta)R_x(\phi)` maps body to world, :math:`\dot\Phi = W(\Phi)\,\Omega`. Of the arm, joint i lies at
:math:`p_i = p_{i-1} + R_{i-1} l_i` with :math:`R_i = R_{i-1}\,\mathrm{Rot}(a_i, \eta_i)`, a point of parent i at
:math:`p_i + R_i o`. With the masses of `Bodies`, :math:`c_i = p_i + R_i o_i`, :math:`c = \tfrac1m\sum m_i c_i` and
:math:`I = \sum R_i I_i R_i^T + m_i\big(r_i^T r_i - r_i r_i^T\big)` about c with :math:`r_i = c_i - c`.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern, Rows


def rotation_body_to_world(attitude: Any) -> Any:
    """R(Φ)."""
    (sr, sp, sy), (cr, cp, cy) = ca.vertsplit(ca.sin(attitude)), ca.vertsplit(ca.cos(attitude))
    return ca.vertcat(
        ca.horzcat(cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        ca.horzcat(sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        ca.horzcat(-sp, cp * sr, cp * cr),
    )


def euler_rates(attitude: Any, body_rates: Any) -> Any:
    """Φ̇ = W(Φ) Ω, (3, 1) [rad/s]; without a number at θ = ±π/2."""
    sr, cr, sp, cp = ca.sin(attitude[0]), ca.cos(attitude[0]), ca.sin(attitude[1]), ca.cos(attitude[1])
    yaw = (sr * body_rates[1] + cr * body_rates[2]) / cp
    return ca.vertcat(body_rates[0] + sp * yaw, cr * body_rates[1] - sr * body_rates[2], yaw)


def body_rates(attitude: Any, rates: Any) -> Any:
    """Ω = W⁻¹(Φ) Φ̇, (3, 1), body frame [rad/s]."""
    sr, cr, sp, cp = ca.sin(attitude[0]), ca.cos(attitude[0]), ca.sin(attitude[1]), ca.cos(attitude[1])
    return ca.vertcat(rates[0] - sp * rates[2], cr * rates[1] + sr * cp * rates[2], -sr * rates[1] + cr * cp * rates[2])


def rotation_about(axis: Any, angle: Any) -> Any:
    r"""Rotation about a unit vector, :math:`c\,1 + s\,\hat a + (1 - c)\,a a^T` (Rodrigues)."""
    cross, s, c = ca.skew(axis), ca.sin(angle), ca.cos(angle)
    return c * ca.SX.eye(3) + s * cross + (1 - c) * (axis @ axis.T)


def arm_frames(pattern: ArmPattern, numbers: Any, angles: Any) -> tuple[list[Any], list[Any]]:
    """Rotations and places of the body (first) and of the arm's joints, in the body."""
    axes, links = (_vectors(rows, numbers) for rows in (pattern.axes, pattern.links))
    rotations, places = [ca.SX.eye(3)], [ca.SX.zeros(3)]
    for i, (axis, link, slides) in enumerate(zip(axes, links, pattern.slides, strict=True)):
        place = places[-1] + rotations[-1] @ link
        places.append(place + rotations[-1] @ (axis * angles[i]) if slides else place)
        rotations.append(rotations[-1] if slides else rotations[-1] @ rotation_about(axis, angles[i]))
    return rotations, places


def arm_points(pattern: ArmPattern, numbers: Any, angles: Any) -> list[Any]:
    """Positions of the arm's constrained points in the body, the tip last."""
    rotations, places = arm_frames(pattern, numbers, angles)
    return [
        places[parent + 1] + rotations[parent + 1] @ offset
        for parent, offset in zip(pattern.parents, _vectors(pattern.offsets, numbers), strict=True)
    ]


def _vectors(rows: Rows, numbers: Any) -> list[Any]:
    return [ca.vertcat(*(numbers[entry] if isinstance(entry, int) else entry for entry in row)) for row in rows]


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
