"""What a door's URDF leaves open: which joint moves, and where that is closed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import UrdfJoint, read_joints

Array = NDArray[np.float64]

_NEAR = 0.15
"""Farthest gap between the leaf's free edge and the jamb that it closes at, as a share of its width."""
_STEPS = 180
"""Of a range that is searched for jambs."""
_AT_END = 0.05
"""By which a closed door may be outside of its range [rad]."""


@dataclass(frozen=True)
class FixedBox:
    """A box beside the leaf that stands still, as its extent along the world's axes."""

    center: Array
    """Shape (3,), world frame [m]."""
    half: Array
    """Shape (3,) [m]."""


def standing_joints(urdf: Path, model: pinocchio.Model, hinge: int) -> tuple[str, ...]:
    """Joints beside the hinge that could move, and that stand at zero because nothing moves them."""
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
        if hinge in _ancestors(model, index):
            raise UrdfError(
                "a joint on the leaf moves, such as a lever or a bolt: pushing does not open a latched door",
                file=urdf, field=f"joint {name}", given=kind, allowed='type="fixed", for a door that is not latched',
            )  # fmt: skip
        if index in _ancestors(model, hinge):
            raise UrdfError(
                "the hinge hangs on another joint that moves", file=urdf, field=f"joint {name}", given=kind,
                allowed=f"one moving joint, '{own}', between world and leaf",
            )  # fmt: skip
        if own in _leaders(joints, name):
            raise UrdfError(
                "a joint follows the hinge, but doorman would hold it still", file=urdf, field=f"joint {name}/mimic", given=own,
                allowed=f"one moving joint, '{own}'",
            )  # fmt: skip
    return tuple(model.names[index] for index in others)


def closed_value(
    limits: tuple[float, float], at_a_jamb: Callable[[float], bool], upright: bool = True
) -> tuple[float, bool]:
    """Joint value at which a door is closed.

    The jamb at the leaf's free edge tells. Without one it is π/2 where the range of an upright door holds that, else an end of
    the range: the one nearer to 0.
    """
    lower, upper = limits
    likely = [value for value in (0.5 * math.pi, 0.0, *limits) if lower - _AT_END <= value <= upper + _AT_END]
    for value in likely:
        if at_a_jamb(value):
            return value, True
    for value in (lower + (upper - lower) * k / _STEPS for k in range(1, _STEPS)):
        if at_a_jamb(value):
            return value, False
    return (likely[0] if upright and likely[0] == 0.5 * math.pi else min(limits, key=abs)), True


def meets(boxes: Iterable[FixedBox], edge: Array, along: Array, width: float) -> bool:
    """Whether a box stands just beyond a leaf's free edge."""
    for box in boxes:
        gap = float(np.linalg.norm(np.maximum(np.abs(edge - box.center) - box.half, 0.0)))
        if gap <= _NEAR * width and float((box.center - edge) @ along) > 0.0:
            return True
    return False


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
