"""Numbers of the estimate at the leaf, by the names that `LeafMotion` knows them by: a new door compiles nothing."""

from __future__ import annotations

import math

import numpy as np

from doorman.kinematics.numbers import Numbers
from doorman.model import Model

JOINT, JOINT_RATE, RESISTANCE, LOG_INERTIA = 9, 10, 11, 12
"""Places of q, its rate, ρ and ln I in the state."""

_TOUCH = {
    "contact.gap": 2e-3,  # deviation of tip and face while they touch: attitude's noise on the tip's lever [m]
    "contact.gap_rate": 0.02,  # of their speed [m/s]
    "contact.pull": 0.15,  # pull that a tip which only pushes may seem to make, by errors of thrust [N]
    "contact.inside": 3e-3,  # by which a free tip may seem to be in the face [m]
    "contact.lasts": 0.05,  # for so long such an error stays: a few poses [s]
    "contact.friction_lasts": 0.5,  # until the tip has slipped to where friction does nothing [s]
    "contact.settles": 0.05,  # until a leaf that stops stands [s]
}
_SWITCH = {
    "switch.near": 4e-3,  # gap from which on a touch is near [m]
    "switch.make": 30.0,  # touches of a near tip [1/s]
    "switch.far": 0.05,  # of one that is away [1/s]
    "switch.lose": 0.1,  # touches that end [1/s]
    "switch.stop": 1.0,  # leaves that come to rest, or begin to move [1/s]
}
_NOISE = {
    "noise.velocity": 0.03,  # rough air and errors of thrust [m/s per √s]
    "noise.wind": 0.15,  # of 1 N that varies by 15 % within a second [N per √s]
    "noise.rate": 0.05,  # forces on the leaf that are not in the model [rad/s per √s]
    "noise.resistance": 0.35,  # wind on the leaf, and friction that differs by place [N m per √s]
    "noise.inertia": 0.05,  # of its logarithm [1 per √s]
    "noise.face": 1e-4,  # [m per √s]
    "noise.friction": 1.5,  # of the tip [N per √s]
}
_START = {
    "start.velocity": 0.05, "start.wind": 0.5, "start.joint": 0.02, "start.joint_rate": 0.01, "start.resistance": 0.6,
    "start.log_inertia": 0.5, "start.face": 2e-3, "start.friction": 0.1,
}  # fmt: skip
"""Deviations before the first touch, SI units."""

TUNED = ("sensor.pose", *_TOUCH, *_SWITCH, *_NOISE, *_START)
"""Names of what is no fact of vehicle or door."""


def leaf_numbers(model: Model, pose_deviation: float) -> Numbers:
    """Numbers of a scenario, of its shipped size; lengths, forces and torques grow with the vehicle."""
    scale = model.scale
    units = {
        "gap": scale.length, "gap_rate": scale.speed, "pull": scale.force, "inside": scale.length, "near": scale.length,
        "velocity": scale.speed, "wind": scale.force, "rate": scale.rate, "resistance": scale.torque,
        "face": scale.length, "friction": scale.force, "joint_rate": scale.rate,
    }  # fmt: skip
    tuned = {**_TOUCH, **_SWITCH, **_NOISE, **_START}
    return model.reduced.numbers.and_also({
        "reference.sense": math.copysign(1.0, model.goal_state[3] - model.start_state[3]),
        "sensor.pose": pose_deviation,
        "contact.stiffness": 1500.0 * scale.stiffness,
        **{name: value * units.get(name.partition(".")[2], 1.0) for name, value in tuned.items()},
    })  # fmt: skip


def first_state(model: Model, numbers: Numbers, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is believed before the first touch, and its deviations."""
    mean = np.zeros(16)
    mean[:3], mean[JOINT] = position, model.start_state[3]
    mean[RESISTANCE], mean[LOG_INERTIA] = 0.5 * model.scale.torque, math.log(model.door.inertia)
    one = numbers.one
    deviations = np.array([
        *[one("sensor.pose")] * 3, *[one("start.velocity")] * 3, *[one("start.wind")] * 3, one("start.joint"),
        one("start.joint_rate"), one("start.resistance"), one("start.log_inertia"), one("start.face"),
        *[one("start.friction")] * 2,
    ])  # fmt: skip
    return mean, deviations
