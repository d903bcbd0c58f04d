r"""Analytic collision constraints h(x) ≤ 0 in symbols (the paper's hard constraints, misprint corrected).

1. :math:`S^3_z,\ \ldots,\ S^n_z,\ d_z \le 0`: the arm stays below the body; an arm above it has the other sign.
2. :math:`R_A\sqrt{n_x^2+n_y^2} - n^T d \le 0` with :math:`n = R^T n_D`: the rotor disc is clear of the leaf's plane.
   :math:`n_x^2+n_y^2 = 1 - n_z^2`, and :math:`n^T d` is the distance of :math:`O_B` from the face.
3. :math:`D_V\sin\alpha - D_w + R_A - a^T R d \le 0` and :math:`a^T R d - D_V\sin\alpha + R_A \le 0`: the disc is between the
   jambs; a is the direction of the closed leaf, the paper's y. The paper prints + D_w in the lower bound; it follows from
   :math:`P_y - P_{hy} \le D_w - R_A` that it is −.

(3) holds a vehicle between the jambs wherever it is. Tasks that are done beside the doorway have other rows in its place, by
their `Surroundings`:

- `corners`: a jamb counts near the wall alone,
  :math:`R_A - \sqrt{\max(b, 0)^2 + \max(a, 0)^2} \le 0`. b is the distance from O_B to the plane of the wall's nearer face,
  a that to the jamb's edge along the wall; inside, either is 0. Between the wall's faces, that is (3).
- `wall`: a vehicle that pulls stays before the wall,
  :math:`R_A\sqrt{1 - (i^T R e_3)^2} + i^T(P - P_h) + b_f \le 0` with the direction i through the doorway and the depth
  :math:`b_f` of the frame.
- `panel`: a vehicle that pushes a slide by a handle stays on the handle's side of it,
  :math:`R_A\sqrt{1 - (p^T R e_3)^2} - (p^T(P - P_h) - c) \le 0` with the plane's normal p and distance c.
"""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.collision.constraint_names import arm_constraint_names
from doorman.collision.surroundings import JAMBS, LEAF, PANEL, WALL, Surroundings
from doorman.kinematics.task import Task
from doorman.ocp.problem.terms import Constraint

_LEAST_EXTENT = 1e-12
"""Under the root: a disc parallel to a plane has a slope, too."""
_ROUNDING = 0.005
"""Of max(0, ·) at a corner [m]."""
_NEVER = -1.0
"""Of a constraint that no posture breaks [m]."""


def collision_constraints(task: Task, margin: Any = 0.0, surroundings: Surroundings = "doorway") -> list[Constraint]:
    """All collision constraints of a task with these surroundings."""
    return [*arm_off_the_rotors(task, margin), *disc_constraints(task, margin, surroundings)]


def disc_constraints(task: Task, margin: Any, surroundings: Surroundings) -> list[Constraint]:
    """Rows of the rotor disc: clear of the leaf, and of what stands beside the door."""
    beside = {
        "doorway": disc_clear_of_jambs, "corners": disc_clear_of_corners, "wall": disc_clear_of_wall,
        "panel": disc_clear_of_panel,
    }  # fmt: skip
    return [disc_clear_of_leaf(task, margin), *beside[surroundings](task, margin)]


def arm_off_the_rotors(task: Task, margin: Any) -> list[Constraint]:
    r"""Rows :math:`m - s z_i \le 0` with the arm's side s = ±1: every point is on that side of the rotors' plane.

    A point that is fixed to the body is not in its way.
    """
    return [
        Constraint(name, ca.SX(_NEVER) if point in task.fixed_points else margin - task.arm_side * place[2])
        for name, (point, place) in zip(
            arm_constraint_names(task.points_in_body, task.arm_side > 0), task.points_in_body.items(), strict=True
        )
    ]


def disc_clear_of_leaf(task: Task, margin: Any) -> Constraint:
    """Row (2): the rotor disc, wherever it tilts, stays on its side of the leaf's plane."""
    return Constraint(LEAF, disc_across(task, task.leaf.normal_in_heading) - task.before_leaf + margin)


def disc_clear_of_jambs(task: Task, margin: Any) -> list[Constraint]:
    """Rows (3): the rotor disc stays inside the doorway's width."""
    across, half = task.across_doorway, task.half_width
    return [
        Constraint(JAMBS[0], across - task.door.width + half + margin),
        Constraint(JAMBS[1], half - across + margin),
    ]


def disc_clear_of_corners(task: Task, margin: Any) -> list[Constraint]:
    """Rows `corners`: the rotor disc stays clear of the jambs' edges before, in and behind the doorway."""
    distances = distances_to_corners(task.across_doorway, task.into_doorway, task.door)
    return [
        Constraint(name, task.vehicle.radius + margin - distance)
        for name, distance in zip(JAMBS, distances, strict=True)
    ]


def distances_to_corners(across: Any, into: Any, door: Any) -> tuple[Any, Any]:
    """Distances of a place from the jambs at latch and hinge, as they reach along the wall [m]."""
    half, middle = 0.5 * (door.frame_depth + door.frame_back), 0.5 * (door.frame_back - door.frame_depth)
    before = _positive(((into - middle) ** 2 + _ROUNDING**2) ** 0.5 - _ROUNDING - half)
    latch, hinge = ((before**2 + _positive(each) ** 2 + _LEAST_EXTENT) ** 0.5 for each in (door.width - across, across))
    return latch, hinge


def disc_clear_of_wall(task: Task, margin: Any) -> list[Constraint]:
    """Row `wall`: the rotor disc, wherever it tilts, stays before the wall."""
    nearest = task.into_doorway + task.door.frame_depth
    return [Constraint(WALL, disc_across(task, task.leaf.into_in_heading) + nearest + margin)]


def disc_clear_of_panel(task: Task, margin: Any) -> list[Constraint]:
    """Row `panel`: the rotor disc, wherever it tilts, stays on its side of a panel that slides."""
    facing = task.leaf.in_heading(task.door.panel)
    return [Constraint(PANEL, disc_across(task, facing) - task.before_panel + margin)]


def disc_across(task: Task, direction: Any) -> Any:
    r"""Half of what the rotor disc takes up along a direction of the leaf's frame, :math:`R_A\sqrt{1 - (n^T R e_3)^2}` [m]."""
    return task.vehicle.radius * (1 - ca.dot(direction, task.tilt_rotation[:, 2]) ** 2 + _LEAST_EXTENT) ** 0.5


def _positive(value: Any) -> Any:
    """max(0, ·), rounded from below."""
    return 0.5 * (value + (value**2 + _ROUNDING**2) ** 0.5 - _ROUNDING)
