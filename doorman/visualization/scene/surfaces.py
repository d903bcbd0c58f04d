r"""Surfaces of the constraints, and how far the vehicle is from each of them.

The clearances are the paper's hard constraints with their sign turned, written for any pose of the vehicle:

- leaf: :math:`n_D^T (P_h - P) - d - R_A \sqrt{n_x^2 + n_y^2}` with :math:`n = R^T n_D`, for a face d before the hinge axis;
- jambs: :math:`a^T r - R_A` and :math:`D_w - R_A - a^T r` with r = P − P_h and the direction a of the closed leaf;
- disc: how far the arm's highest point is below the plane of the rotors.

The door is the true one. Where the planner knows the same one, they are :math:`-h(x)` with the tip at its contact point.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.urdf.elements import link_name
from doorman.model import Model
from doorman.visualization.scene.moments import Moment
from doorman.visualization.scene.shapes import VisualShape

SURFACES = ("leaf", "jamb at the hinge", "jamb at the latch", "disc over the arm")
"""In the order of the clearances."""

_COLOR = (0.34, 0.71, 0.91, 0.15)
_THIN = 0.002
_PROUD = 0.004
"""In front of what it covers, so that both can be seen [m]."""
_DEPTH = (-0.7, 0.4)
"""Depth of the jambs' planes, through the doorway [m]."""
_HIGH = 0.5
"""Surfaces are drawn as bands at the contact's height [m]."""


def clearances(model: Model, moment: Moment) -> Array:
    door, radius, width = model.true_door, model.vehicle.radius, model.true_door.width
    normal, away = door.normal(moment.door_angle), moment.position - door.hinge_position
    in_body = rotation_body_to_world(moment.attitude).T @ normal
    leaf = -normal @ away - door.surface_offset - radius * np.hypot(in_body[0], in_body[1])
    across = float(door.along @ away)
    arm = -model.vehicle.point_positions(moment.arm_angles)[:, 2].max()
    return np.array([leaf, across - radius, width - radius - across, arm])


def surface_shapes(model: Model) -> dict[str, VisualShape]:
    door, base = model.true_door, model.vehicle.names.base_link
    height = model.scenario.contact.height
    leaf = _on_the_leaf(model)
    length, middle = _DEPTH[1] - _DEPTH[0], 0.5 * (_DEPTH[0] + _DEPTH[1])
    jambs = [
        _box(
            (length, _THIN, _HIGH),
            door.hinge_position + door.from_doorway(np.array([middle, across, height])),
            door.azimuth,
        )
        for across in (_PROUD, door.width - _PROUD)
    ]
    disc = VisualShape("", "cylinder", (model.vehicle.radius, 0.001), np.eye(4), _COLOR)
    return {
        f"/scene/door/{door.section.leaf}/surface": leaf,
        "/scene/jamb_at_hinge": jambs[0],
        "/scene/jamb_at_latch": jambs[1],
        f"/scene/vehicle/{base}/disc": disc,
    }


def _on_the_leaf(model: Model) -> VisualShape:
    """A plane before the leaf's face, in the leaf's frame."""
    door = model.true_door
    placement = door.link_placements(0.5 * np.pi)[link_name(door.urdf, door.section.leaf)]
    middle = np.array([-_PROUD - door.surface_offset, 0.5 * door.width, model.scenario.contact.height])
    there = _box((_THIN, door.width, _HIGH), door.hinge_position + door.from_doorway(middle), door.azimuth)
    return replace(there, placement=np.linalg.inv(placement) @ there.placement)


def _box(size: tuple[float, float, float], center: Array, azimuth: float) -> VisualShape:
    placement = np.eye(4)
    placement[:3, :3] = rotation_body_to_world([0.0, 0.0, azimuth])
    placement[:3, 3] = center
    return VisualShape("", "box", size, placement, _COLOR)
