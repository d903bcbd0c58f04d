"""The planner's collision constraints along a flight, from true positions: they hold away from the door, too.

The planner knows the vehicle's place by its tip on the leaf. Here it is where it was, and a row counts where it says something:
the arm's always, the leaf's while the disc is beside the leaf, those of jambs and lintel while
some of the disc is in the doorway.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.collision.rows.kind import dot
from doorman.collision.rows.listed import ARM, KINDS
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model


def flown_constraints(model: Model, position: Array, attitude: Array, door_angle: Array, arm_angles: Array) -> Array:
    """Rows h ≤ 0 of `collision.rows` at true states, against the true door; −∞ where a row says nothing."""
    door, radius = model.true_door, model.vehicle.radius
    states = np.hstack([attitude, door_angle[:, None], np.zeros((len(attitude), 1)), arm_angles])
    seen = _flown(model, position, attitude, door_angle, arm_angles)
    along_leaf = dot(door.leaf_directions(door_angle).T, seen.position_from_hinge)
    into = seen.into_doorway
    within = (into > -door.frame_depth - radius) & (into < radius)
    counts = {
        "leaf": (along_leaf > -radius) & (along_leaf < door.width + radius), "doorway": within, "lintel": within,
    }  # fmt: skip
    everywhere = np.ones(len(attitude), dtype=bool)
    columns = [model.constraints_along(states)[:, : len(model.vehicle.point_names)]]
    for kind in model.kinds:
        if kind != ARM:
            rows = KINDS[kind].excess(seen, 0.0)
            columns.append(np.where(counts.get(kind, everywhere), np.stack(rows), -np.inf).T)
    return np.hstack(columns)


def _flown(model: Model, position: Array, attitude: Array, door_angle: Array, arm_angles: Array) -> Any:
    """What rows use of a task, in numbers: vectors are (3, m), world frame. The disc is level between jambs, as in plans."""
    door, vehicle = model.true_door, model.vehicle
    from_hinge = (position - door.hinge_position).T
    normal = door.normals(door_angle).T
    face = door.surface_offset if door.panel is None else door.contact_offset
    panel = {} if door.panel is None else {"panel": door.from_doorway(door.panel[0])}
    points: dict[str, Array] = {}
    if vehicle.arm.above or "lintel_edge" in model.kinds:
        names = vehicle.point_names
        places = np.array([vehicle.point_positions(angles) for angles in arm_angles]).reshape(-1, len(names), 3)
        points = {name: places[:, i].T for i, name in enumerate(names)}
    return SimpleNamespace(
        vehicle=SimpleNamespace(radius=vehicle.radius),
        door=SimpleNamespace(
            width=door.width, frame_depth=door.frame_depth, frame_back=door.frame_back, frame_height=door.frame_height, **panel
        ),
        leaf=SimpleNamespace(normal_in_heading=normal, into_in_heading=door.into, up=door.up, in_heading=np.asarray),
        tilt_rotation=np.stack([rotation_body_to_world(each) for each in attitude], axis=-1),
        position_from_hinge=from_hinge, before_leaf=-dot(normal, from_hinge) - face - door.way(door_angle),
        across_doorway=dot(door.along, from_hinge), into_doorway=dot(door.into, from_hinge), half_width=vehicle.radius,
        before_panel=0.0 if door.panel is None else dot(panel["panel"], from_hinge) - door.panel[1],
        points_in_body=points, arm_side=1 if vehicle.arm.above else -1,
    )  # fmt: skip
