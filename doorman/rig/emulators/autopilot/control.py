r"""The emulated autopilot's own position controller, and what it can be asked to do.

What mixer and motors make of the normalised thrust that an emulated autopilot asks for.

.. math::
    \tau = k u^2 + (1 - k)\,u, \qquad \frac{f}{f_{max}} = u^2

for the signal u of motors whose thrust is its square, as that of propellers is, and with k of PX4's `THR_MDL_FAC` or
ArduPilot's `MOT_THST_EXPO`. At k = 0 the autopilot takes the signal for the thrust, at k = 1 it linearises the motors.

PX4 makes forces to the side by rotors that its parameters CA_ROTORi place and tilt: the pseudo-inverse of what the rotors do,
each of its columns divided by the mean of its entries that are not zero, turns normalised thrust into the rotors' shares.
Sources: PX4, parameter reference and `ControlAllocationPseudoInverse.cpp`; ArduPilot,
`AP_MotorsMulticopter::apply_thrust_curve_and_volt_scaling`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from doorman.arrays import Array
from doorman.gravity import weight_of
from doorman.kinematics.quaternions import multiply
from doorman.kinematics.rotations import quaternion_of
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.rig.emulators.autopilot.dialects import ParameterStore
from doorman.rig.emulators.autopilot.estimator import FLIP, LEVEL, NOTHING, Estimate


def thrust_share(normalised: float, k: float) -> float:
    """f/f_max = u² of motors whose thrust is the signal squared."""
    if k < 1e-6:
        return normalised * normalised
    u = (math.sqrt((1.0 - k) ** 2 + 4.0 * k * normalised) - (1.0 - k)) / (2.0 * k)
    return u * u


def normalised_thrust(share: float, k: float) -> float:
    """τ of a share of the largest thrust, the inverse of `thrust_share`."""
    return k * share + (1.0 - k) * math.sqrt(share)


def rotor_parameters(rotors: RotorLayout) -> dict[str, float]:
    """Places, directions of thrust, and moments of a vehicle's rotors, by name of PX4's parameters."""
    moments = rotors.torque_per_thrust * rotors.directions
    rows = np.column_stack([rotors.positions * FLIP, rotors.thrust_axes * FLIP, moments])
    return {
        f"CA_ROTOR{i}_{name}": value
        for i, row in enumerate(rows.tolist())
        for name, value in zip(("PX", "PY", "PZ", "AX", "AY", "AZ", "KM"), row, strict=True)
    }


def add_rotors(parameters: ParameterStore, rotors: RotorLayout) -> None:
    parameters.add("CA_ROTOR_COUNT", rotors.count, whole=True)
    for name, value in rotor_parameters(rotors).items():
        parameters.add(name, value)


def side_force(parameters: ParameterStore, share: tuple[float, float], full: float) -> tuple[float, float]:
    """Force along the body's x and y axis, z up, that normalised thrust along them becomes [N]."""
    if not any(share) or "CA_ROTOR_COUNT" not in parameters:
        return 0.0, 0.0
    rotors = [f"CA_ROTOR{i}_" for i in range(int(parameters["CA_ROTOR_COUNT"]))]
    places, axes = (np.array([[parameters[r + kind + x] for x in "XYZ"] for r in rotors]) * FLIP for kind in "PA")
    moments = np.array([parameters[r + "KM"] for r in rotors])
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    wrench = np.vstack([axes.T, (np.cross(places, axes) - moments[:, None] * axes).T])
    signals = np.zeros(len(axes))
    for column, each in zip(np.linalg.pinv(wrench)[:, :2].T, share, strict=True):
        acting = np.abs(column[np.abs(column) > 1e-6])
        signals += column / acting.mean() * each if acting.size else 0.0
    x, y, _ = full / axes[:, 2].sum() * (signals @ axes)
    return float(x), float(y)


class Task(Enum):
    IDLE = "motors idle on the ground"
    ATTITUDE = "attitude and thrust"
    POSITION = "position"
    VELOCITY = "velocity"
    LAND = "descend until on the ground"


@dataclass(frozen=True)
class Demand:
    task: Task
    quaternion: Array = field(default_factory=lambda: LEVEL)
    thrust: float = 0.0  # share of the largest, 0 … 1
    side: tuple[float, float] = (0.0, 0.0)  # thrust along the body's x and y axis, as normalised, −1 … 1
    position: Array = field(default_factory=lambda: NOTHING)
    velocity: Array = field(default_factory=lambda: NOTHING)
    acceleration: Array = field(default_factory=lambda: NOTHING)
    yaw: float | None = None


class FlightController:
    position_gain, velocity_gain = 2.2, 3.2  # [1/s]
    most_speed, landing_speed = np.array([1.5, 1.5, 1.0]), 0.6  # [m/s]
    most_tilt = 0.6  # [rad]

    def __init__(self, weight: float) -> None:
        self._weight = weight
        self._anchor: Array | None = None  # where a landing began, shape (3,) [m]

    def actuate(self, demand: Demand, estimate: Estimate, max_force: float) -> tuple[float, Array]:
        if demand.task is not Task.LAND:
            self._anchor = None
        if demand.task is Task.ATTITUDE:
            return demand.thrust * max_force, demand.quaternion
        acceleration = demand.acceleration + self.velocity_gain * (self._velocity(demand, estimate) - estimate.velocity)
        return self._force(acceleration, estimate.yaw if demand.yaw is None else demand.yaw)

    def _velocity(self, demand: Demand, estimate: Estimate) -> Array:
        if demand.task is Task.VELOCITY:
            return demand.velocity
        if demand.task is Task.LAND:
            self._anchor = estimate.position if self._anchor is None else self._anchor
            x, y, _ = np.clip(self.position_gain * (self._anchor - estimate.position), -1.0, 1.0)
            return np.array([x, y, -self.landing_speed])
        wanted = demand.velocity + self.position_gain * (demand.position - estimate.position)
        return np.clip(wanted, -self.most_speed, self.most_speed)

    def _force(self, acceleration: Array, yaw: float) -> tuple[float, Array]:
        x, y, z = acceleration.tolist()
        fall = weight_of(1.0)
        vertical = max(0.3 * fall, fall + min(max(z, -5.0), 5.0))
        scale = min(1.0, vertical * math.tan(self.most_tilt) / max(1e-9, math.hypot(x, y)))
        x, y = scale * x, scale * y
        length = math.sqrt(x * x + y * y + vertical * vertical)
        return self._weight * length / fall, tilted((x / length, y / length, vertical / length), yaw)


def tilted(axis: tuple[float, float, float], yaw: float) -> Array:
    """Attitude whose z axis points along a unit vector, with a heading: the least tilt, then the turn."""
    x, y, z = axis
    w = math.sqrt(0.5 * (1.0 + z))
    return np.array(multiply((w, -y / (2.0 * w), x / (2.0 * w), 0.0), quaternion_of((0.0, 0.0, yaw))))
