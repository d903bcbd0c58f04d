"""Which joints of a vehicle's URDF are the arm's, the chain from the base link to the tip, and their limits."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.arrays import Array, frozen, sealed
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import read_joints
from doorman.kinematics.urdf.robot import frame_index, link_index
from doorman.kinematics.vehicles.rotors import is_rotor, rotor_links

_KINDS = ("revolute", "continuous", "prismatic")
MOST_JOINTS = 7


def arm_chain(full: pinocchio.Model, base_link: str, tip: str, urdf: Path) -> list[int]:
    """Joints from the base link to the tip; none where the tip is fixed to the base link."""
    base = full.frames[link_index(full, base_link, urdf, "vehicle.base_link")].parentJoint
    carrying = list(full.supports[full.frames[frame_index(full, tip, urdf, "vehicle.tip")].parentJoint])
    written = read_joints(urdf)
    floats = all(written[full.names[index]].kind == "floating" for index in list(full.supports[base])[1:])
    rotor = is_rotor(tip) or tip in rotor_links(urdf)
    if base not in carrying or tip == base_link or rotor or not floats:
        raise UrdfError(
            "no chain of joints leads from the base link to the tip", file=urdf, field="vehicle.tip", given=tip,
            allowed=f"a link that '{base_link}' carries; '{base_link}' is the root, fixed to it, or floats on it",
        )  # fmt: skip
    chain = carrying[carrying.index(base) + 1 :]
    for index in chain:
        kind = written[full.names[index]].kind
        if kind not in _KINDS:
            raise UrdfError(
                "a joint of the arm has an unknown type", file=urdf, field=f"joint {full.names[index]}", given=kind,
                allowed=", ".join((*_KINDS, "fixed")),
            )  # fmt: skip
    if len(chain) > MOST_JOINTS:
        raise UrdfError(
            "the arm has too many joints", file=urdf, field="vehicle.tip", given=len(chain),
            allowed=f"up to {MOST_JOINTS}; type=\"fixed\" for joints that stand",
        )  # fmt: skip
    return chain


def standing_joints(full: pinocchio.Model, base_link: str, arm: tuple[str, ...]) -> tuple[str, ...]:
    """Joints that could move, are neither of the arm nor rotors, and stand at zero."""
    above = list(full.supports[full.frames[full.getFrameId(base_link, pinocchio.FrameType.BODY)].parentJoint])
    others = (str(full.names[i]) for i in range(1, full.njoints) if i not in above)
    return tuple(name for name in others if name not in arm and not is_rotor(name))


def check_followers(urdf: Path, chain: set[str]) -> None:
    """Check that no joint of the arm follows another, and nothing else follows the arm: both would stand still."""
    for name, joint in read_joints(urdf).items():
        if joint.leader is not None and (name in chain or joint.leader in chain):
            what = "a joint of the arm follows another" if name in chain else "a joint follows the arm"
            raise UrdfError(
                what, file=urdf, field=f"joint {name}/mimic", given=joint.leader,
                allowed="joints that move on their own",
            )  # fmt: skip


class JointLimits(NamedTuple):
    """Of n joints, in the units of each."""

    slides: NDArray[np.bool_]
    """Whether joints are prismatic."""
    lower: Array
    """Least values; a continuous joint has none, whatever its `<limit>` says."""
    upper: Array
    rates: Array
    torques: Array


def joint_limits(urdf: Path, model: pinocchio.Model, names: Sequence[str]) -> JointLimits:
    """Limits of joints that can move, hold something, and have a range."""
    joints = read_joints(urdf)
    kinds = [joints[name].kind for name in names]
    slides, endless = (
        np.array([each == kind for each in kinds], dtype=np.bool_) for kind in ("prismatic", "continuous")
    )
    lower = np.where(endless, -np.inf, model.lowerPositionLimit)
    upper = np.where(endless, np.inf, model.upperPositionLimit)
    for name, rate, torque, least, most in zip(
        names, model.velocityLimit, model.effortLimit, lower, upper, strict=True
    ):
        for holds, what, field, given, allowed in (
            (rate > 0.0, "cannot move", "velocity", rate, "> 0 rad/s, or m/s of a prismatic joint"),
            (torque > 0.0, "cannot hold anything", "effort", torque, "> 0 N m, or N of a prismatic joint"),
            (least < most, "has no range", "upper", most, f'> {least:g}, or type="fixed"'),
        ):
            if not holds:
                where = f"joint {name}/limit@{field}"
                raise UrdfError(
                    f"a joint of the arm {what}", file=urdf, field=where, given=float(given), allowed=allowed
                )
    return JointLimits(sealed(slides), *map(frozen, (lower, upper, model.velocityLimit, model.effortLimit)))
