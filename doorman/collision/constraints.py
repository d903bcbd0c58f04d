r"""Analytic collision constraints h(x) ≤ 0 in symbols (the paper's hard constraints, misprint corrected).

1. :math:`S^3_z,\ \ldots,\ S^n_z,\ d_z \le 0`: the arm stays below the body; an arm above it has the other sign.
2. :math:`R_A\sqrt{n_x^2+n_y^2} - n^T d \le 0` with :math:`n = R^T n_D`: the rotor disc is clear of the leaf's plane.
3. :math:`D_V\sin\alpha - D_w + R_A - a^T R d \le 0` and :math:`a^T R d - D_V\sin\alpha + R_A \le 0`: the disc is between the
   jambs; a is the direction of the closed leaf, the paper's y. The paper prints + D_w in the lower bound; it follows from
   :math:`P_y - P_{hy} \le D_w - R_A` that it is −.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.collision.constraint_names import arm_constraint_names
from doorman.kinematics.task import Task
from doorman.ocp.problem.terms import Constraint

_LEAST_EXTENT = 1e-24
"""Under the root: a disc parallel to the leaf has a slope, too."""
_NEVER = -1.0
"""Of a constraint that no posture breaks [m]."""


def collision_constraints(task: Task, margin: Any = 0.0) -> list[Constraint]:
    """All of them.

    Args:
        task: The door task.
        margin: Distance to keep besides [m].
    """
    return [*arm_off_the_rotors(task, margin), disc_clear_of_leaf(task, margin), *disc_clear_of_jambs(task, margin)]


def arm_off_the_rotors(task: Task, margin: Any) -> list[Constraint]:
    """Every point of the arm lies on the arm's side of the rotors' plane; one that is fixed to the body is not in its way."""
    return [
        Constraint(name, ca.SX(_NEVER) if point in task.fixed_points else margin - task.arm_side * place[2])
        for name, (point, place) in zip(
            arm_constraint_names(task.points_in_body, task.arm_side > 0), task.points_in_body.items(), strict=True
        )
    ]


def disc_clear_of_leaf(task: Task, margin: Any) -> Constraint:
    """The rotor disc, wherever it tilts, stays on its side of the leaf's plane."""
    normal = task.tilt_rotation.T @ task.normal_in_heading
    extent = (normal[0] ** 2 + normal[1] ** 2 + _LEAST_EXTENT) ** 0.5
    return Constraint("disc clear of leaf", task.vehicle.radius * extent - normal.T @ task.tip_in_body + margin)


def disc_clear_of_jambs(task: Task, margin: Any) -> list[Constraint]:
    """The rotor disc stays inside the doorway's width."""
    across, radius = task.across_doorway, task.vehicle.radius
    return [
        Constraint("disc clear of latch jamb", across - task.door.width + radius + margin),
        Constraint("disc clear of hinge jamb", radius - across + margin),
    ]
