"""Rotors of a vehicle, from its URDF."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.kinematics.urdf import frame_index, frozen
from doorman.kinematics.urdf_elements import read_joints

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rotor:
    """One rotor: where it is, how it turns and how hard it can pull."""

    position: Array
    """In the body, shape (3,) [m]."""
    direction: float
    """+1 counter-clockwise seen from above, −1 clockwise."""
    max_thrust: float
    """[N]."""


def read_rotors(urdf: Path, model: pinocchio.Model, base: pinocchio.SE3) -> tuple[Rotor, ...]:
    """Fixed joints named `rotor_…`: their limit's effort is the rotor's largest thrust, their axis its sense.

    Args:
        urdf: Path of the URDF.
        model: Pinocchio's model of it.
        base: Placement of the base link in the model's root frame.

    Returns:
        The rotors that are fixed to the base link and have a thrust, in the order of the URDF.

    Raises:
        UrdfError: if the file is not a URDF.
    """
    rotors = []
    for joint in read_joints(urdf).values():
        if not joint.name.startswith("rotor") or not model.existFrame(joint.child):
            continue
        frame = model.frames[frame_index(model, joint.child, urdf, joint.name)]
        if frame.parentJoint != 0 or not joint.effort > 0.0:
            continue
        direction = -1.0 if joint.axis[2] < 0.0 else 1.0
        rotors.append(Rotor(frozen(base.actInv(frame.placement.translation)), direction, joint.effort))
    return tuple(rotors)
