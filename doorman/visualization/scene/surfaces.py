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
from doorman.visualization.scene.shapes import Kind, VisualShape

SURFACES = ("leaf", "jamb at the hinge", "jamb at the latch", "disc over the arm")
"""In the order of the clearances."""


def clearances(model: Model, moment: Moment) -> Array:
    door, radius, width = model.true_door, model.vehicle.radius, model.true_door.width
    normal, away = door.normal(moment.door_angle), moment.position - door.hinge_position
    in_body = rotation_body_to_world(moment.attitude).T @ normal
    leaf = -normal @ away - door.surface_offset - radius * np.hypot(in_body[0], in_body[1])
    across = float(door.along @ away)
    arm = -model.vehicle.point_positions(moment.arm_angles)[:, 2].max()
    return np.array([leaf, across - radius, width - radius - across, arm])


def surface_shapes(model: Model, before: float = 0.004, high: float = 0.5) -> dict[str, VisualShape]:
    """Bands of that height at the contact's, as far before what they cover, so that both can be seen [m]."""
    door, contact = model.true_door, model.scenario.contact.height

    def band(length: float, width: float, middle: tuple[float, float]) -> VisualShape:
        placement = np.eye(4)
        placement[:3, :3] = rotation_body_to_world([0.0, 0.0, door.azimuth])
        placement[:3, 3] = door.hinge_position + door.from_doorway(np.array([*middle, contact]))
        return _surface("box", (length, width, high), placement)

    leaf = band(0.002, door.width, (-before - door.surface_offset, 0.5 * door.width))
    closed = door.link_placements(0.5 * np.pi)[link_name(door.urdf, door.section.leaf)]
    jambs = (band(1.1, 0.002, (-0.15, across)) for across in (before, door.width - before))
    return {
        f"/scene/door/{door.section.leaf}/surface": replace(leaf, placement=np.linalg.inv(closed) @ leaf.placement),
        **dict(zip(("/scene/jamb_at_hinge", "/scene/jamb_at_latch"), jambs, strict=True)),
        f"/scene/vehicle/{model.vehicle.names.base_link}/disc": _surface(
            "cylinder", (model.vehicle.radius, 0.001), np.eye(4)
        ),
    }


def _surface(kind: Kind, size: tuple[float, ...], placement: Array) -> VisualShape:
    return VisualShape("", kind, size, placement, color=(0.34, 0.71, 0.91, 0.15))
