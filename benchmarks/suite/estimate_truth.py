"""What a simulation's truth says of wind, resistance and slips: from its motion and forces, as no sensor sees them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.replay import LeafReplay
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recording

Array = NDArray[np.float64]

_SHORT, _LONG = 5, 25
"""Ticks over which speeds, and forces, are smoothed."""

_SLIP, _SLIP_LASTS = 0.08, 0.06
"""Speed on the face [m/s], and time for which it is kept [s], from which on a tip slips."""
_STILL, _BEFORE = 0.025, 0.15
"""Speed below which it does not [m/s], if for so long [s]; a slip counts as found if that is said within this time."""


class LeafTruth:
    """By tick: wind on the vehicle (n, 3) [N], resistance of a hinge (n,) [N m], speed of the tip on the face (n,) [m/s]."""

    def __init__(self, recording: Recording, model: Model) -> None:
        truth, numbers = recording["truth"], model.reduced.numbers
        self.time, self.touches = truth.time, truth["touching"].astype(bool)
        rotations = np.array([rotation_body_to_world(angles) for angles in truth["attitude"]])
        rotors = rotations[:, :, 2] * truth["rotor_thrusts"].sum(axis=1)[:, None]
        accelerations = np.gradient(truth["velocity"], truth.time, axis=0) + [0.0, 0.0, GRAVITY]
        self.wind = _smooth(model.vehicle.mass * accelerations - rotors + truth["tip_force"], _LONG)
        tips = np.array([model.vehicle.tip_position(angles) for angles in truth["arm_angles"]])
        tip = truth["position"] + np.einsum("nij,nj->ni", rotations, tips) - numbers["door.hinge_position"]
        hand = numbers.one("door.hand")
        turned = (np.cross([0.0, 0.0, hand], tip) * truth["tip_force"]).sum(axis=1)
        driven = turned - model.true_door.inertia * np.gradient(truth["door_rate"], truth.time)
        sense = np.sign(model.goal_state[3] - model.start_state[3])
        self.resistance = _smooth(sense * driven[:, None], 2 * _LONG)[:, 0]
        azimuth = numbers.one("door.azimuth") + hand * truth["door_angle"]
        along = np.cos(azimuth) * tip[:, 0] + np.sin(azimuth) * tip[:, 1]
        speeds = np.gradient(np.column_stack([along, tip[:, 2]]), truth.time, axis=0)
        self.slip_speed = np.hypot(*_smooth(speeds, _SHORT).T)


def slips(truth: LeafTruth, found: LeafReplay) -> str:
    """How many were found, of how many, and how many were invented."""
    edges = np.flatnonzero(np.diff(((truth.slip_speed > _SLIP) & truth.touches).astype(int), prepend=0, append=0))
    true = [
        (truth.time[a], truth.time[min(b, len(truth.time) - 1)]) for a, b in zip(edges[::2], edges[1::2], strict=True)
    ]
    true = [(begins, ends) for begins, ends in true if ends - begins >= _SLIP_LASTS]
    said = found.time[found.slips]
    seen = sum(bool(((said > begins - _BEFORE) & (said < begins + _BEFORE)).any()) for begins, _ in true)
    tick = truth.time[1] - truth.time[0]
    fastest = np.array([
        truth.slip_speed[(at := int(time / tick)) - int(_BEFORE / tick) : at + 1].max(initial=0.0) for time in found.time
    ])  # fmt: skip
    invented = np.asarray(found.slips, dtype=bool) & (fastest < _STILL)
    return f"{seen} of {len(true)}, {int((np.diff(invented.astype(int), prepend=0) > 0).sum())}"


def _smooth(values: Array, ticks: int) -> Array:
    kernel = np.ones(ticks) / ticks
    return np.column_stack([np.convolve(column, kernel, mode="same") for column in values.T])
