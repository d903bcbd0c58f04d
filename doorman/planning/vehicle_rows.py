"""Rows of what a vehicle can do at all: hold its arm level, and make a force with a level body."""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.ocp.problem.terms import Constraint

_SCALE = 10.0
"""What counts as much as a metre of the planes [N]."""


def static_moment(task: Any) -> list[Constraint]:
    r"""The centre of mass of an arm with mass stays where the rotors hold it, see `Balance`: :math:`n_k^T c(H) \le r_k`."""
    polygon = getattr(task, "balance", None)
    if polygon is None:
        return []
    sides = ca.reshape(polygon.normals, 2, polygon.reaches.numel()).T
    return [Constraint("static moment", sides @ task.center_of_mass[:2] - polygon.reaches, "m")]


def rotor_thrusts(task: Any) -> list[Constraint]:
    r"""Thrusts :math:`l f + S\,[f_x, f_y]^T` of a fully actuated vehicle's `RotorRoom`, between least and most."""
    rotors = getattr(task, "actuation", None)
    if rotors is None:
        return []
    sides = ca.reshape(rotors.sides, 2, rotors.lifts.numel()).T
    thrusts = rotors.lifts * task.thrust + sides @ task.side_force
    return [Constraint("thrust of a rotor", thrusts, "N", _SCALE, lower=rotors.least, upper=rotors.most)]
