"""True causes that may have kept a mission from its end, to compare with the reason that it states."""

from __future__ import annotations

import math

import numpy as np

from doorman.model import Model
from doorman.recording import Recording

SLIPPED, NEVER_CLOSED = "the gripper slipped", "the gripper never closed"
LATCHED, SEALED, HELD = "the latch held the door", "the seal held the door", "a hand held the door"
WIND, DRAUGHT = "strong wind", "a draught"
ELSEWHERE, AJAR = "the door is elsewhere", "the door was ajar"
FRAME, LATE, NOISY = "the frame of the poses moved", "the poses were late", "the poses were noisy"
WEAK = "the thrust differs from the command"

_WIND_SHARE = 0.1
"""Share of the weight from which on wind counts as strong: a tenth is a tilt of 6 degrees."""
_FAR, _TURNED, _OPEN = 0.01, math.radians(1.0), math.radians(2.0)
"""A door, or the frame of the poses, so far from where it is believed [m], [rad], or a door so far open [rad], counts as
elsewhere, or ajar."""
_LATE = 0.03
"""Age of poses from which on they are late [s]."""
_NOISY = 0.001
"""Noise of positions from which on poses are noisy [m]."""
_OFF = 0.08
"""Share by which thrust over weight must be off."""


def true_causes(recording: Recording, model: Model) -> list[str]:
    """What was true of a flight that may explain why it failed; the keys of `[simulation]` decide, and what happened."""
    truth, true, door = recording["truth"], model.scenario.simulation, model.true_door
    grips, weight, duration = model.scenario.contact.kind == "grip", model.vehicle.weight, float(truth.time[-1])
    lowest, highest = float(truth["door_angle"].min()), float(truth["door_angle"].max())
    farthest = max(door.opening_of(lowest), door.opening_of(highest))
    pushed = bool(np.any(truth["touching"]))  # a leaf that was never pushed was held by nothing
    mass = model.vehicle.mass if true.vehicle_mass is None else true.vehicle_mass
    left = true.thrust_scale * math.exp(-true.thrust_fall * duration) * model.vehicle.mass / mass
    sensors = true.sensors
    jumps = sensors.jump if sensors.jump_rate * duration > 0.5 else 0.0
    turned = abs(sensors.turn_rate) * float(np.linalg.norm(truth["position"], axis=1).max())
    age = sensors.latency + sensors.jitter + (0.0 if sensors.rate is None else 1.0 / sensors.rate)
    causes = {
        NEVER_CLOSED: grips and true.gripper_force == 0.0,
        SLIPPED: grips and "grip_slips" in truth and truth["grip_slips"][-1] > 0,
        LATCHED: pushed and true.door_latch > 0.0 and farthest < true.door_latch_angle,
        SEALED: pushed and true.door_seal > 0.0 and farthest < true.door_seal_angle,
        HELD: true.hand.door_angle is not None and lowest <= true.hand.door_angle,
        ELSEWHERE: math.hypot(*true.door_offset) > _FAR or abs(true.door_yaw) > _TURNED,
        AJAR: abs(true.door_ajar) > _OPEN,
        WIND: "outer_force" in truth and float(truth["outer_force"].max()) > _WIND_SHARE * weight,
        DRAUGHT: abs(true.gust.draught) > 0.5 * _WIND_SHARE * weight,
        WEAK: abs(left - 1.0) > _OFF,
        FRAME: jumps + (sensors.drift + turned) * duration > _FAR,
        LATE: age > _LATE,
        NOISY: true.noise.position >= _NOISY,
    }
    return [cause for cause, holds in causes.items() if holds]
