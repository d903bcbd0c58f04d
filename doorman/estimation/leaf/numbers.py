"""Numbers of the estimate at the leaf, by the names that `LeafMotion` knows them by: a new door compiles nothing."""

from __future__ import annotations

import itertools
import math

import numpy as np

from doorman.kinematics.numbers import Numbers
from doorman.model import Model

STATES = {
    "position": 3, "velocity": 3, "wind": 3, "wind_turn": 1, "gust": 1, "lift": 1, "joint": 1, "joint_rate": 1,
    "resistance": 1, "log_inertia": 1, "face": 1, "reach": 1, "friction": 2,
}  # fmt: skip
"""Parts of the state in their order, and how many numbers each has; see `LeafMotion`."""
_ENDS = dict(zip(STATES, itertools.accumulate(STATES.values()), strict=True))
PLACES = {name: slice(_ENDS[name] - size, _ENDS[name]) for name, size in STATES.items()}
JOINT, JOINT_RATE = PLACES["joint"].start, PLACES["joint_rate"].start
SIZE = sum(STATES.values())

FACE = 1.5e-3
"""Deviation of a face whose place is known: a tip is softer or harder than assumed [m]."""
_TOUCH = {
    "contact.gap": 1e-3,  # deviation of tip and face while they touch: their shapes and compliance [m]
    "contact.gap_rate": 5e-3,  # of their speed [m/s],
    "contact.slip_rate": 5e-3,  # and of its speed in the face where it grips [m/s]
    "contact.pull": 0.15,  # pull that a tip which only pushes may seem to make, by errors of thrust [N]
    "contact.inside": 3e-3,  # by which a free tip may seem to be in the face [m]
    "contact.lasts": 0.05,  # for so long such an error stays: a few poses [s]
    "contact.friction": 0.3,  # deviation of the tip's friction, as a share of the normal force
    "contact.friction_lasts": 5.0,  # until a tip that creeps has lost the friction that it had [s]
    "contact.settles": 0.05,  # until a leaf that stops stands [s]
    "contact.sticks": 0.3,  # until a leaf that stands is believed to resist with more than it bears [s],
    "contact.more": 0.2,  # by so much on average [N m]
}
_SWITCH = {
    "switch.near": 4e-3,  # gap from which on a touch is near [m]
    "switch.make": 30.0,  # touches of a near tip [1/s]
    "switch.far": 0.05,  # of one that is away [1/s],
    "switch.reach": 0.1,  # by no more than this gap: no leaf comes so far without being felt [m]
    "switch.lose": 0.1,  # touches that end [1/s]
    "switch.slip": 2e-3,  # grips that end [1/s]
    "switch.jump": 1e-3,  # winds that jump: rare, and plain when they do [1/s]
    "switch.calm": 5.0,  # jumps that end [1/s]
    "switch.throw": 0.02,  # gripped leaves that a hand or a gust throws or catches [1/s]
    "switch.stop": 1.0,  # leaves that come to rest, or begin to move [1/s]
}
_NOISE = {
    "noise.velocity": 0.025,  # rough air and errors of thrust [m/s per √s]
    "noise.bounce": 0.02,  # of the normal force, as a share of it: the tip swings on its compliance [√s]
    "noise.wind": 0.03,  # of the mean wind [N per √s]
    "noise.jump": 3.0,  # of one that jumps: by about 1 N in 0.1 s [N per √s]
    "noise.gust": 0.15,  # deviation of the wind's strength, as a share of its mean
    "noise.gust_lasts": 1.0,  # for so long a gust stays [s]
    "noise.draught": 0.05,  # of vertical wind [N per √s]
    "noise.wind_turn": 1e-3,  # of the wind's turn rate [rad/s per √s]
    "noise.lift": 0.003,  # batteries sag: of the lift's share [1 per √s]
    "noise.rate": 0.05,  # forces on the leaf that are not in the model [rad/s per √s]
    "noise.throw": 3.0,  # of a gripped leaf that is thrown: by 1 rad/s in 0.1 s [rad/s per √s]
    "noise.thrown_along": 2.0,  # and of the vehicle that goes along [m/s per √s]
    "noise.drawn": 0.3,  # share of the resistance that draws an open leaf back, a closer [√s]
    "noise.resistance": 0.35,  # wind on the leaf, and friction that differs by place [N m per √s]
    "noise.gives": 1.0,  # share of what a leaf that rests bears, which may give way [1 per √s]
    "noise.inertia": 0.05,  # of its logarithm [1 per √s]
    "noise.face": 2e-5,  # [m per √s]
}
_START = {
    "start.velocity": 0.05, "start.wind": 0.5, "start.draught": 0.2, "start.wind_turn": 0.1, "start.gust": 0.15,
    "start.lift": 0.05, "start.joint": 0.02, "start.joint_rate": 2e-3, "start.resistance": 0.6, "start.log_inertia": 0.5,
    "start.face": FACE, "start.reach": 0.02, "start.friction": 0.1,
}  # fmt: skip
"""Deviations before the first touch, SI units."""

_STOP = 3e-3
"""Deviation of a leaf that is at its stop [rad or m]."""

_TIP_FORCE = 0.5
"""Deviation of what a sensor in the tip reads from the force of a stiff contact [N]: the tip swings on its compliance."""

LEAVES = {"switch.lose": 10.0, "switch.make": 1.0}
"""The same of a tip that is to come off the leaf: of one that follows it and one that stays, the latter is the likelier."""

_LEAF = 5e-3
"""Deviation of a sensor of the leaf whose readings come without their own [rad or m]."""

_ON_LEVER = 0.05
"""Deviation of that speed where the tip holds a lever, which turns on the leaf: 0.12 m long, by 0.4 rad/s [m/s]."""

_SHARES = ("contact.friction", "switch.jump", "switch.throw")
"""Numbers that do not grow with the vehicle, unlike their namesakes."""

TUNED = ("sensor.pose", "sensor.tip_force", "sensor.leaf", *_TOUCH, *_SWITCH, *_NOISE, *_START)
"""Names of what is no fact of vehicle or door."""


def leaf_numbers(model: Model, pose_deviation: float) -> Numbers:
    """Numbers of a scenario, of its shipped size; lengths, forces and torques grow with the vehicle."""
    scale, torque = model.scale, _torque(model)
    units = {
        "gap": scale.length, "gap_rate": scale.speed, "slip_rate": scale.speed, "pull": scale.force, "inside": scale.length,
        "near": scale.length,
        "velocity": scale.speed, "wind": scale.force, "jump": scale.force, "draught": scale.force,
        "wind_turn": scale.rate, "rate": scale.rate, "throw": scale.rate, "thrown_along": scale.speed,
        "resistance": torque, "more": torque, "face": scale.length,
        "reach": scale.length, "friction": scale.force, "joint_rate": scale.rate,
    }  # fmt: skip
    tuned = {**_TOUCH, **_SWITCH, **_NOISE, **_START}
    if model.scenario.door.beside and not model.door.in_plane:
        tuned["contact.slip_rate"] = _ON_LEVER
    if model.door.at_its_stop(model.start_angle):
        tuned["start.joint"] = _STOP
    if model.scenario.contact.kind == "push":
        doubt = model.scenario.estimation
        turned = 0.0 if model.door.slides else model.coupling.lever_length * doubt.door_yaw_deviation
        tuned["start.face"] = max(math.hypot(doubt.door_place_deviation, turned) / scale.length, FACE)
    bodies = {} if model.vehicle.bodies.balanced else model.vehicle.bodies.numbers()
    return model.reduced.numbers.and_also({
        **bodies,
        "reference.sense": math.copysign(1.0, model.goal_state[3] - model.start_state[3]),
        "sensor.pose": pose_deviation,
        "sensor.tip_force": math.hypot(_TIP_FORCE * scale.force, *_of_the_sensor(model)),
        "sensor.leaf": _LEAF,
        "contact.stiffness": 1500.0 * scale.stiffness,
        "contact.borne": np.zeros(2),  # by a lever that the tip holds down, along leaf and hinge [N]
        "contact.way": 1.0,  # a leaf that stands is to go on, or back: -1
        **{
            name: value * (1.0 if name in _SHARES else units.get(name.partition(".")[2], 1.0))
            for name, value in tuned.items()
        },
    })  # fmt: skip


def _torque(model: Model) -> float:
    """Unit of the torques that a joint resists with: the vehicle's, or that of a lever, which is shorter than any leaf."""
    return model.hinge_scale if model.door.in_plane else model.scale.torque


def _of_the_sensor(model: Model) -> tuple[float, float]:
    """Deviations of what a sensor in the tip reads: noise, and an offset that no free flight shows [N]."""
    doubt = model.scenario.estimation
    return doubt.tip_force_noise, doubt.tip_force_offset if model.scenario.mission.start == "contact" else 0.0


def first_state(model: Model, numbers: Numbers, position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What is believed before the first touch, and its deviations."""
    parts = {
        "position": position, "joint": model.start_state[3], "resistance": 0.5 * _torque(model),
        "log_inertia": math.log(model.door.inertia),
    }  # fmt: skip
    mean, deviations = np.zeros(SIZE), np.zeros(SIZE)
    for name, place in PLACES.items():
        mean[place] = parts.get(name, 0.0)
        deviations[place] = numbers.one("sensor.pose" if name == "position" else f"start.{name}")
    deviations[PLACES["wind"].stop - 1] = numbers.one("start.draught")
    return mean, deviations
