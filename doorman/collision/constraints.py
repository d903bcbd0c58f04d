"""The collision constraints h(x) ≤ 0 as rows of a problem; `rows` has their equations."""

from __future__ import annotations

from typing import Any

from doorman.collision.rows.listed import ARM, IN_A_DOORWAY, KINDS, Kinds
from doorman.kinematics.task import Task
from doorman.ocp.problem.terms import Constraint


def collision_constraints(task: Task, margin: Any = 0.0, kinds: Kinds = IN_A_DOORWAY) -> list[Constraint]:
    """All collision constraints of a task that has these kinds."""
    points, above = tuple(task.points_in_body), task.arm_side > 0
    return [
        Constraint(name, value)
        for kind in kinds
        for name, value in zip(KINDS[kind].names(points, above), KINDS[kind].excess(task, margin), strict=True)
    ]


def disc_constraints(task: Task, margin: Any, kinds: Kinds) -> list[Constraint]:
    """Those that keep the vehicle away from door and frame."""
    return collision_constraints(task, margin, tuple(kind for kind in kinds if kind != ARM))
