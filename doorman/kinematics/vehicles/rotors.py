"""Rotors of a vehicle, from its URDF."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array, frozen
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import UrdfJoint, read_joints
from doorman.kinematics.urdf.robot import frame_index

_WORD = "rotor"
"""How the last part of the name of a rotor's joint begins."""
_BETWEEN_PARTS = re.compile(r"(?:[/:.]|__)(?!\d)")
"""What ROS, Gazebo and others put between a namespace and a name; not what parts a name from its number."""
_LYING = 0.1
"""Share of the thrust along the body's z axis below which the frame says which way a rotor blows, and above which it lifts."""


@dataclass(frozen=True)
class Rotor:
    """One rotor: where it is, how it turns and how hard it can pull."""

    position: Array
    """In the body, shape (3,) [m]."""
    direction: float
    """+1 counter-clockwise seen from where its thrust points to, −1 clockwise."""
    max_thrust: float
    """[N]."""
    axis: Array
    """Unit vector of its thrust, in the body, shape (3,)."""


def is_rotor(name: str) -> bool:
    """Whether a joint is a rotor's, by the last part of its name: `rotor_1`, `uav1/rotor_1`, `iris__rotor_0_joint`."""
    return _BETWEEN_PARTS.split(name)[-1].lower().startswith(_WORD)


def read_rotors(urdf: Path, model: pinocchio.Model, assume: bool = False) -> tuple[Rotor, ...]:
    """Joints named `rotor_…`: their limit's effort is the rotor's largest thrust, their axis its sense."""
    joints = _joints(urdf)
    rotors = [_rotor(urdf, model, joint) for joint in joints]
    if not any(joint.effort > 0.0 if assume else joint.limited for joint in joints):
        return ()
    for joint in joints:
        if not joint.effort > 0.0:
            raise UrdfError(
                "a rotor has no thrust", file=urdf, field=f"joint {joint.name}/limit@effort",
                given=joint.effort if joint.limited else "no <limit>", allowed="> 0 N, the rotor's largest thrust",
            )  # fmt: skip
    return tuple(rotors)


def rotor_links(urdf: Path) -> list[str]:
    """Links of the rotors, in the order of the URDF, whether their thrust is known or not."""
    return [joint.child for joint in _joints(urdf)]


def _joints(urdf: Path) -> list[UrdfJoint]:
    return [joint for joint in read_joints(urdf).values() if is_rotor(joint.name)]


def _rotor(urdf: Path, model: pinocchio.Model, joint: UrdfJoint) -> Rotor:
    frame = model.frames[frame_index(model, joint.child, urdf, joint.name)]
    where = f"joint {joint.name}"
    if frame.parentJoint != 0:
        raise UrdfError(
            "a rotor moves with the arm", file=urdf, field=where, given=f"behind joint {model.names[frame.parentJoint]}",
            allowed="a rotor fixed to the base link",
        )  # fmt: skip
    own = np.array(joint.axis) / np.linalg.norm(joint.axis)
    axis = frame.placement.rotation @ own
    towards = axis[2] if abs(axis[2]) > _LYING else own[2]
    sense = -1.0 if towards < 0.0 else 1.0
    return Rotor(frozen(frame.placement.translation), sense, joint.effort, frozen(sense * axis))
