"""What a door's URDF leaves open: which joint moves, and where that is closed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import UrdfJoint, read_joints
from doorman.kinematics.urdf.shapes import read_collisions

_NEAR = 0.15
"""Farthest gap between the leaf's free edge and the jamb that it closes at, as a share of its width."""
_STEPS = 180
"""Angles at which a joint's range is searched for jambs."""
_AT_END = 0.05
"""By which a closed door may be outside of its range [rad]."""


_ROUNDED = 2e-3
"""By which files round a right angle [rad]."""


@dataclass(frozen=True)
class FixedBox:
    """A box beside the leaf that stands still, as its extent along the world's axes."""

    center: Array
    """Shape (3,), world frame [m]."""
    half: Array
    """Shape (3,) [m]."""


@dataclass(frozen=True)
class Closed:
    """Joint value at which a door is closed."""

    value: float
    """[rad or m]."""
    guessed: bool = False
    """Whether neither the scenario nor a jamb tells."""
    doubtful: bool = False
    """Whether the leaf meets a jamb there that need not be the one at which it is closed."""


def standing_joints(urdf: Path, model: pinocchio.Model, hinge: int, known: Iterable[str] = ()) -> tuple[str, ...]:
    """Joints beside the hinge that could move, and that stand still because nothing moves them, or where they are known to."""
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
        if hinge in _ancestors(model, index):
            raise UrdfError(
                "a joint on the leaf moves, such as a lever or a bolt: pushing does not open a latched door",
                file=urdf, field=f"joint {name}", given=kind, allowed='type="fixed", for a door that is not latched',
            )  # fmt: skip
        if index in _ancestors(model, hinge) and _stands_on_something(urdf, model, index):
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


def closed_value(limits: tuple[float, float], at_a_jamb: Callable[[float], bool], upright: bool = True) -> Closed:
    """Where a door is closed.

    The jamb at the leaf's free edge tells. Without one it is guessed: the end of the range at 0, else π/2 where the range of an
    upright door holds that, else the end nearer to 0.
    """
    lower, upper = limits
    at_zero = [end for end in limits if abs(end) <= _AT_END]
    ends = sorted(limits, key=abs)
    beside = [
        end for end in limits if _ROUNDED < abs(end - 0.5 * math.pi) <= _AT_END
    ]  # a range ends where the door is shut
    likely = [
        value for value in (*at_zero, *beside, 0.5 * math.pi, 0.0, *ends) if lower - _AT_END <= value <= upper + _AT_END
    ]
    for value in likely:
        if at_a_jamb(value):
            return Closed(value)
    for value in (lower + (upper - lower) * k / _STEPS for k in range(1, _STEPS)):
        if at_a_jamb(value):
            return Closed(value, doubtful=True)
    return Closed(likely[0] if at_zero or (upright and likely[0] == 0.5 * math.pi) else ends[0], guessed=True)


def meets(boxes: Iterable[FixedBox], edge: Array, along: Array, width: float) -> bool:
    """Whether a box stands just beyond a leaf's free edge."""
    for box in boxes:
        gap = float(np.linalg.norm(np.maximum(np.abs(edge - box.center) - box.half, 0.0)))
        if gap <= _NEAR * width and float((box.center - edge) @ along) > 0.0:
            return True
    return False


def _stands_on_something(urdf: Path, model: pinocchio.Model, index: int) -> bool:
    """Whether anything is below a joint; the joints of a base that floats or rolls have only empty links there."""
    below = {0, *_ancestors(model, index)} - {index}
    links = {frame.name for frame in model.frames if frame.parentJoint in below}
    return any(shape.link in links for shape in read_collisions(urdf))


def _ancestors(model: pinocchio.Model, index: int) -> Iterator[int]:
    while index != 0:
        index = int(model.parents[index])
        yield index


def _leaders(joints: dict[str, UrdfJoint], name: str) -> set[str]:
    found: set[str] = set()
    leader = joints[name].leader
    while leader is not None and leader in joints and leader not in found:
        found.add(leader)
        leader = joints[leader].leader
    return found
