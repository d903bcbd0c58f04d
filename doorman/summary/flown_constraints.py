"""The planner's collision constraints along a flight, from true positions: they hold away from the door, too.

The planner knows the vehicle's place by its tip on the leaf. Here it is where it was, and a row counts where it says something:
the arm's always, the leaf's while the disc is beside the leaf, the jambs' while some of the disc is between them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model

Array = NDArray[np.float64]


def flown_constraints(model: Model, position: Array, attitude: Array, door_angle: Array, arm_angles: Array) -> Array:
    r"""Rows h ≤ 0 at true states.

    The place from the true hinge is :math:`r = P - P_h`. With the true leaf's normal :math:`n_D`, the distance o of its face
    before the hinge axis and the direction a of the closed leaf, the rows of the disc are

    .. math::
        R_A\sqrt{1 - (n_D^T R e_3)^2} + n_D^T r + o, \qquad a^T r - D_w + R_A, \qquad R_A - a^T r ,

    and those of `collision.constraints` for other surroundings than a doorway. Of a slide with a panel beside the vehicle, o is
    that of its handle's face.
    """
    door, radius, arm = model.true_door, model.vehicle.radius, len(model.vehicle.point_names)
    states = np.hstack([attitude, door_angle[:, None], np.zeros((len(attitude), 1)), arm_angles])
    upright = np.array([rotation_body_to_world(one)[:, 2] for one in attitude]).reshape(-1, 3)
    away, upright = door.in_doorway(position - door.hinge_position), door.in_doorway(upright)
    angles = door_angle.tolist()
    normal = door.in_doorway(np.array([door.normal(angle) for angle in angles]).reshape(-1, 3))
    leaf_direction = door.in_doorway(np.array([door.leaf_direction(angle) for angle in angles]).reshape(-1, 3))
    way = np.array([door.way(angle) for angle in angles])
    face = door.surface_offset if door.panel is None else door.contact_offset
    before_leaf = -(normal * away).sum(axis=1) - face - way
    along_leaf, facing = (leaf_direction * away).sum(axis=1), (normal * upright).sum(axis=1)
    leaf = radius * np.sqrt(np.maximum(1.0 - facing**2, 0.0)) - before_leaf
    beside_leaf = (along_leaf > -radius) & (along_leaf < door.width + radius)
    beside = _beside(model, away, upright)
    return np.column_stack([model.constraints_along(states)[:, :arm], np.where(beside_leaf, leaf, -np.inf), *beside])


def _beside(model: Model, away: Array, upright: Array) -> list[Array]:
    """Rows of what stands beside the door."""
    door, radius = model.true_door, model.vehicle.radius
    if door.panel is not None:
        normal, distance = door.panel
        return [radius * np.sqrt(np.maximum(1.0 - (upright @ normal) ** 2, 0.0)) - away @ normal + distance]
    if model.surroundings == "wall":
        extent = radius * np.sqrt(np.maximum(1.0 - upright[:, 0] ** 2, 0.0))
        return [extent + away[:, 0] + door.frame_depth]
    if model.surroundings == "doorway":
        within = (away[:, 0] > -door.frame_depth - radius) & (away[:, 0] < radius)
        rows = (away[:, 1] - door.width + radius, radius - away[:, 1])
        return [np.where(within, row, -np.inf) for row in rows]
    before = np.maximum(np.maximum(-door.frame_depth - away[:, 0], away[:, 0] - door.frame_back), 0.0)
    return [radius - np.hypot(before, np.maximum(each, 0.0)) for each in (door.width - away[:, 1], away[:, 1])]
