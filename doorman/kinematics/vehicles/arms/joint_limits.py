"""Limits of an arm's joints, as the URDF gives them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.arrays import Array, frozen
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import read_joints


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
    lower = np.where(endless, -np.inf, model.lowerPositionLimit)
    upper = np.where(endless, np.inf, model.upperPositionLimit)
    limits = zip(names, model.velocityLimit, model.effortLimit, lower, upper, strict=True)
    for name, rate, torque, least, most in limits:
        for holds, what, field, given, allowed in (
            (rate > 0.0, "cannot move", "velocity", rate, "> 0 rad/s, or m/s of a prismatic joint"),
            (torque > 0.0, "cannot hold anything", "effort", torque, "> 0 N m, or N of a prismatic joint"),
            (least < most, "has no range", "upper", most, f'> {least:g}, or type="fixed"'),
        ):
            if not holds:
                raise UrdfError(
                    f"a joint of the arm {what}",
                    file=urdf,
                    field=f"joint {name}/limit@{field}",
                    given=float(given),
                    allowed=allowed,
                )
    return JointLimits(slides, frozen(lower), frozen(upper), frozen(model.velocityLimit), frozen(model.effortLimit))
