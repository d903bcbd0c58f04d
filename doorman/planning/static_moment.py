r"""The bound on the arm's static moment: the centre of mass stays where the rotors hold the vehicle level, see `Balance`.

.. math:: n_k^T c(H) \le r_k
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.ocp.problem.terms import Constraint


def static_moment(task: Any) -> list[Constraint]:
    """Rows of a task whose arm has mass; none of another."""
    polygon = getattr(task, "balance", None)
    if polygon is None:
        return []
    sides = ca.reshape(polygon.normals, 2, polygon.reaches.numel()).T
    return [Constraint("static moment", sides @ task.center_of_mass[:2] - polygon.reaches, "m")]
