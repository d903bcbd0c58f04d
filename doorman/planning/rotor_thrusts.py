"""Rows on inputs: what the rotors of a fully actuated vehicle make with its body level."""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.ocp.problem.terms import Constraint

_SCALE = 10.0
"""What counts as much as a metre of the planes [N]."""


def rotor_thrusts(rotors: Any, thrust: Any, side_force: Any) -> list[Constraint]:
    r"""Thrusts :math:`l f + S\,[f_x, f_y]^T` of `RotorRoom`, between least and most."""
    if rotors is None:
        return []
    sides = ca.reshape(rotors.sides, 2, rotors.lifts.numel()).T
    thrusts = rotors.lifts * thrust + sides @ side_force
    return [Constraint("thrust of a rotor", thrusts, "N", _SCALE, lower=rotors.least, upper=rotors.most)]
