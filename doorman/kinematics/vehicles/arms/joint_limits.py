"""Limits of an arm's joints, as the URDF gives them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.elements import read_joints
from doorman.kinematics.urdf.robot import frozen


def sliding(urdf: Path, names: Sequence[str]) -> NDArray[np.bool_]:
    """Whether joints are prismatic, shape (n,), read-only."""
    joints = read_joints(urdf)
    slides = np.array([joints[name].kind == "prismatic" for name in names], dtype=np.bool_)
    slides.flags.writeable = False
    return slides


def position_limits(urdf: Path, model: pinocchio.Model, names: Sequence[str]) -> tuple[Array, Array]:
    """Lower and upper limits of the joints; a continuous one has none, whatever its `<limit>` says."""
    joints = read_joints(urdf)
    endless = np.array([joints[name].kind == "continuous" for name in names], dtype=np.bool_)
    lower, upper = model.lowerPositionLimit, model.upperPositionLimit
    return frozen(np.where(endless, -np.inf, lower)), frozen(np.where(endless, np.inf, upper))


def positive_rates(urdf: Path, model: pinocchio.Model, names: Sequence[str]) -> Array:
    """Largest rates of the joints."""
    for name, rate in zip(names, model.velocityLimit, strict=True):
        if not rate > 0.0:
            raise UrdfError(
                "a joint of the arm cannot move", file=urdf, field=f"joint {name}/limit@velocity",
                given=float(rate), allowed="> 0 rad/s, or m/s of a prismatic joint",
            )  # fmt: skip
    return frozen(model.velocityLimit)


def positive_torques(urdf: Path, model: pinocchio.Model, names: Sequence[str], lower: Array, upper: Array) -> Array:
    """Largest torques of the joints."""
    for name, torque, least, most in zip(names, model.effortLimit, lower, upper, strict=True):
        if not torque > 0.0:
            raise UrdfError(
                "a joint of the arm cannot hold anything", file=urdf, field=f"joint {name}/limit@effort",
                given=float(torque), allowed="> 0 N m, or N of a prismatic joint",
            )  # fmt: skip
        if not least < most:
            raise UrdfError(
                "a joint of the arm has no range", file=urdf, field=f"joint {name}/limit@upper",
                given=float(most), allowed=f"> {least:g}, or type=\"fixed\"",
            )  # fmt: skip
    return frozen(model.effortLimit)
