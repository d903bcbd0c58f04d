"""Limits of an arm's joints, as the URDF gives them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import read_joints
from doorman.kinematics.urdf.robot import frozen


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
    slides, endless = (
        np.array([joints[name].kind == kind for name in names], dtype=np.bool_) for kind in ("prismatic", "continuous")
    )
    slides.flags.writeable = False
    lower, upper = (
        np.where(endless, -np.inf, model.lowerPositionLimit),
        np.where(endless, np.inf, model.upperPositionLimit),
    )
    for name, rate, torque, least, most in zip(
        names, model.velocityLimit, model.effortLimit, lower, upper, strict=True
    ):
        for holds, what, field, given, allowed in (
            (rate > 0.0, "a joint of the arm cannot move", "velocity", rate, "> 0 rad/s, or m/s of a prismatic joint"),
            (
                torque > 0.0,
                "a joint of the arm cannot hold anything",
                "effort",
                torque,
                "> 0 N m, or N of a prismatic joint",
            ),
            (least < most, "a joint of the arm has no range", "upper", most, f'> {least:g}, or type="fixed"'),
        ):
            if not holds:
                raise UrdfError(
                    what, file=urdf, field=f"joint {name}/limit@{field}", given=float(given), allowed=allowed
                )
    return JointLimits(slides, frozen(lower), frozen(upper), frozen(model.velocityLimit), frozen(model.effortLimit))
