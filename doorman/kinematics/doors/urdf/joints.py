"""Joints of a door's URDF: the one that moves the leaf, where all others stand, and which of them hang on the leaf."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import UrdfJoint, read_collisions, read_joints, read_parents
from doorman.scenario import DoorSection


def hinge_joint(urdf: Path, full: pinocchio.Model, name: str) -> int:
    """Index of the joint that moves the leaf."""
    if not full.existJointName(name):
        joints = ", ".join(list(full.names)[1:]) or "none that moves"
        raise UrdfError(
            f"the URDF has no moving joint '{name}'", file=urdf, field="door.hinge", given=name, allowed=joints
        )
    index = int(full.getJointId(name))
    if full.joints[index].nq != 1:
        raise UrdfError(
            "the door's joint is no hinge with a range, and no slide", file=urdf, field=f"joint {name}",
            given=full.joints[index].shortname().removeprefix("JointModel"), allowed="revolute, continuous or prismatic",
        )  # fmt: skip
    return index


def standing_joints(
    urdf: Path, model: pinocchio.Model, hinge: int, known: Iterable[str] = (), unlatched: bool = False
) -> tuple[str, ...]:
    """Joints beside the hinge that could move, and that stand still because nothing moves them, or where they are known to.

    One on the leaf is the lever of a latch, unless the scenario says that the door has none.
    """
    known = frozenset(known)
    joints = read_joints(urdf)
    own = model.names[hinge]
    others = [index for index in range(1, model.njoints) if index != hinge]
    if joints[own].leader is not None:
        raise UrdfError(
            "the hinge follows another joint", file=urdf, field=f"joint {own}/mimic", given=joints[own].leader,
            allowed="a hinge that moves on its own",
        )  # fmt: skip
    for index in others:
        name = model.names[index]
        kind = joints[name].kind
        if name in known or known & _leaders(joints, name):
            continue
        if hinge in model.supports[index] and not unlatched:
            raise UrdfError(
                "a joint on the leaf moves, such as a lever or a bolt: pushing does not open a latched door",
                file=urdf, field=f"joint {name}", given=kind,
                allowed="door.latch and what turns its lever first, or door.latched = false for a door that is not latched",
            )  # fmt: skip
        if index in model.supports[hinge] and _stands_on_something(urdf, model, index):
            raise UrdfError(
                "the hinge hangs on another joint that moves", file=urdf, field=f"joint {name}", given=kind,
                allowed=f"one moving joint, '{own}', between world and leaf",
            )  # fmt: skip
        if own in _leaders(joints, name):
            raise UrdfError(
                "a joint follows the hinge, but doorman would hold it still", file=urdf, field=f"joint {name}/mimic", given=own,
                allowed=f"one moving joint, '{own}'",
            )  # fmt: skip
    unknown = (model.names[index] for index in others)
    return tuple(name for name in unknown if name not in known and not known & _leaders(joints, name))


def standing_values(section: DoorSection) -> dict[str, float]:
    """Where joints stand that move before this task or after it, and the lever of a latch."""
    lever = {} if section.latch is None else {section.latch.joint: section.latch.closed}
    values = lever | {joint.joint: joint.value for joint in section.beside}
    return {name: value for name, value in values.items() if name != section.hinge}


def levers(urdf: Path, section: DoorSection) -> Iterator[str]:
    """Links that hang by another joint of the task on what the hinge moves."""
    beside, parents = {each.joint for each in section.beside}, read_parents(urdf)
    for link, (joint, _) in parents.items():
        at = link if joint in beside else None
        while at in parents:
            above, at = parents[at]
            if above == section.hinge:
                yield link


def places(full: pinocchio.Model, values: dict[str, float]) -> Array:
    """Coordinates of all joints, zero where none is given."""
    places = np.array(pinocchio.neutral(full))
    for name, value in values.items():
        if full.existJointName(name):
            places[full.joints[full.getJointId(name)].idx_q] = value
    return places


def _stands_on_something(urdf: Path, model: pinocchio.Model, index: int) -> bool:
    """Whether anything is below a joint; the joints of a base that floats or rolls have only empty links there."""
    below = set(model.supports[index]) - {index}
    links = {frame.name for frame in model.frames if frame.parentJoint in below}
    return any(shape.link in links for shape in read_collisions(urdf))


def _leaders(joints: dict[str, UrdfJoint], name: str) -> set[str]:
    found: set[str] = set()
    leader = joints[name].leader
    while leader is not None and leader in joints and leader not in found:
        found.add(leader)
        leader = joints[leader].leader
    return found
