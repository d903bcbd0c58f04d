"""Links of a URDF's tree: the joint that carries each, and where it sits on that joint."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio

from doorman.arrays import Array, frozen


class Link(NamedTuple):
    """A link as its joint carries it."""

    joint: int
    """Index of the joint in Pinocchio's model; 0 is the root."""
    placement: Array
    """Homogeneous matrix of the link in the joint's frame, shape (4, 4)."""


def links_of(model: pinocchio.Model) -> dict[str, Link]:
    """Links by name."""
    return {
        frame.name: Link(int(frame.parentJoint), frozen(frame.placement.homogeneous))
        for frame in model.frames
        if frame.type == pinocchio.FrameType.BODY
    }


def joint_placements_along(model: pinocchio.Model, data: pinocchio.Data, values: Array) -> Array:
    """Placements of all joints at each of m configurations, by forward kinematics."""
    placements = np.empty((len(values), model.njoints, 4, 4))
    for at, configuration in zip(placements, values, strict=True):
        pinocchio.forwardKinematics(model, data, configuration)
        for joint, placement in enumerate(data.oMi):
            at[joint] = placement.homogeneous
    return placements
