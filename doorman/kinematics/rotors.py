"""Rotors of a vehicle, from its URDF."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.exceptions import UrdfError
from doorman.kinematics.urdf import frame_index, frozen
from doorman.kinematics.urdf_elements import UrdfJoint, read_joints

Array = NDArray[np.float64]

PREFIX = "rotor"
"""How the name of a rotor's joint begins."""
_LARGEST_TILT = math.radians(1.0)
"""Of a rotor that counts as upright: 1.7 % of its thrust go to the side."""


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
    """Joints named `rotor_…`: their limit's effort is the rotor's largest thrust, their axis its sense.

    Args:
        urdf: Path of the URDF.
        model: Pinocchio's model of it, in which the rotors stand still.
        base: Placement of the base link in the model's root frame.

    Returns:
        The rotors, in the order of the URDF; none where none of them has a limit.

    Raises:
        UrdfError: if the file is not a URDF, or a rotor moves with the arm, has no thrust, or is tilted.
    """
    joints = [joint for joint in read_joints(urdf).values() if joint.name.startswith(PREFIX)]
    rotors = [_rotor(urdf, model, base, joint) for joint in joints]
    if not any(joint.limited for joint in joints):
        return ()
    for joint in joints:
        if not joint.effort > 0.0:
            raise UrdfError(
                "a rotor has no thrust", file=urdf, field=f"joint {joint.name}/limit@effort",
                given=joint.effort if joint.limited else "no <limit>", allowed="> 0 N, the rotor's largest thrust",
            )  # fmt: skip
    return tuple(rotors)


def rotor_links(urdf: Path) -> list[str]:
    """Links of the rotors, in the order of the URDF, whether their thrust is known or not.

    Args:
        urdf: Path of the URDF.

    Raises:
        UrdfError: if the file is not a URDF.
    """
    return [joint.child for joint in read_joints(urdf).values() if joint.name.startswith(PREFIX)]


def _rotor(urdf: Path, model: pinocchio.Model, base: pinocchio.SE3, joint: UrdfJoint) -> Rotor:
    frame = model.frames[frame_index(model, joint.child, urdf, joint.name)]
    where = f"joint {joint.name}"
    if frame.parentJoint != 0:
        raise UrdfError(
            "a rotor moves with the arm", file=urdf, field=where, given=f"behind joint {model.names[frame.parentJoint]}",
            allowed="a rotor fixed to the base link",
        )  # fmt: skip
    axis = base.rotation.T @ frame.placement.rotation @ np.array(joint.axis) / np.linalg.norm(joint.axis)
    tilt = math.acos(min(abs(float(axis[2])), 1.0))
    if tilt > _LARGEST_TILT:
        raise UrdfError(
            "a rotor is tilted, and would be flown as an upright one", file=urdf, field=f"{where}/axis, origin@rpy",
            given=f"{math.degrees(tilt):.1f}° off the body's z axis",
            allowed=f"an axis along ±z of the body, within {math.degrees(_LARGEST_TILT):.0f}°",
        )  # fmt: skip
    direction = -1.0 if axis[2] < 0.0 else 1.0
    return Rotor(frozen(base.actInv(frame.placement.translation)), direction, joint.effort)
