r"""Servos: PI velocity control of the arm's joints, with limits of rate, torque and angle from the URDF.

.. math::
    \tau = \mathrm{sat}(K_v (r - \dot\eta) + z), \qquad \dot z = K_i (r - \dot\eta)

r is the commanded rate, cut at the rate limit and before the joint's end. MuJoCo sees a damper of :math:`K_v` with a moving
reference, which it integrates implicitly. The torque limit is put on the reference and not on the actuator: a servo that
slips keeps its damper, without which the joint's small armature and the stiff contact would need a far smaller time step.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.kinematics.scale import Scale
from doorman.kinematics.vehicles.vehicle import Vehicle

_ARMATURE = 0.01
"""Inertia of a servo's motor seen through its gear, of the shipped vehicle as all servos here [kg m²]."""
_RATE_GAIN = 100.0
"""K_v [N m s/rad]."""
_INTEGRAL_GAIN = 2000.0
"""K_i [N m/rad]: a lasting load of 5 N m turns a servo by 0.0025 rad, then no further."""
_BRAKING = 10.0
"""Deceleration towards a joint's end [rad/s²]: half of what the torque limit allows with the default gains at 1 kHz."""
_LEVER = 0.25
"""Lever of the turning servo with the stiffness of a sliding one; its square scales gains and inertia, itself braking [m]."""
UNLIMITED = 1e6
"""Stands for a limit that the URDF leaves out (zero or infinite)."""


def limit_or_none(limit: float) -> float:
    """A limit of effort or velocity as the servos use it: `UNLIMITED` where the URDF has none."""
    return float(limit) if 0.0 < limit < UNLIMITED else UNLIMITED


def add_servos(spec: Any, mujoco: Any, vehicle: Vehicle, prefix: str) -> None:
    """Give every arm joint a velocity servo; their controls are references [rad/s], in the order of the joints."""
    armature, rate_gain, _, _ = servo_numbers(vehicle)
    for index, name in enumerate(vehicle.joint_names):
        joint = spec.joint(prefix + name)
        joint.armature = float(armature[index])
        joint.actfrclimited = False
        lower, upper = vehicle.lower_limits[index], vehicle.upper_limits[index]
        joint.limited = bool(lower > -UNLIMITED and upper < UNLIMITED)
        actuator = spec.add_actuator(name=f"servo_{name}", target=prefix + name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_velocity(kv=float(rate_gain[index]))


def servo_numbers(vehicle: Vehicle) -> tuple[Array, Array, Array, Array]:
    """Inertia, K_v, K_i and braking of every joint's servo, in the vehicle's units."""
    scale = Scale.of(vehicle.radius, vehicle.mass)
    levers = np.array([_LEVER * scale.length if slides else 1.0 for slides in vehicle.slides])
    torque, time = scale.torque / levers**2, scale.time
    numbers = _ARMATURE * time**2 * torque, _RATE_GAIN * time * torque, _INTEGRAL_GAIN * torque
    return *numbers, _BRAKING / time**2 * levers


class ServoParameters(NamedTuple):
    """Numbers and memory of the servo kernel."""

    positions: NDArray[np.int64]  # index of every joint in qpos, shape (n,)
    velocities: NDArray[np.int64]  # index of every joint in qvel, shape (n,)
    lower: Array  # ends of every joint, shape (n,) [rad], and all that follows in N and m where a joint slides
    upper: Array
    largest_rate: Array  # shape (n,) [rad/s]
    largest_torque: Array  # shape (n,) [N m]
    rate_gain: Array  # K_v, shape (n,) [N m s/rad]
    integral_gain: Array  # K_i, shape (n,) [N m/rad]
    braking: Array  # shape (n,) [rad/s²]
    integral: Array  # memory: z, shape (n,) [N m]
    period: float  # of the loop [s]

    @classmethod
    def of(
        cls, vehicle: Vehicle, positions: NDArray[np.int64], velocities: NDArray[np.int64], period: float
    ) -> ServoParameters:
        """Parameters of a vehicle's arm, with cleared memory."""
        rates = np.array([limit_or_none(limit) for limit in vehicle.rate_limits], dtype=np.float64)
        torques = np.array([limit_or_none(limit) for limit in vehicle.torque_limits], dtype=np.float64)
        lower, upper = np.array(vehicle.lower_limits), np.array(vehicle.upper_limits)
        _, rate_gain, integral_gain, braking = servo_numbers(vehicle)
        return cls(
            positions, velocities, lower, upper, rates, torques, rate_gain, integral_gain, braking, np.zeros(vehicle.n_arm),
            period,
        )  # fmt: skip


@kernel
def servo_rate(commanded: float, angle: float, lower: float, upper: float, largest: float, braking: float) -> float:
    """Rate that a servo follows: the commanded one, inside its limit, and so that it can stop at the joint's end [rad/s]."""
    rate = min(max(commanded, -largest), largest)
    rate = min(rate, math.sqrt(2.0 * braking * max(upper - angle, 0.0)))
    return max(rate, -math.sqrt(2.0 * braking * max(angle - lower, 0.0)))


@kernel
def servo_references(p: ServoParameters, qpos: Array, qvel: Array, commanded: Array, references: Array) -> None:
    """References of the velocity actuators, from MuJoCo's state and the commanded rates."""
    for j in range(p.integral.shape[0]):
        angle, rate = qpos[p.positions[j]], qvel[p.velocities[j]]
        wanted = servo_rate(commanded[j], angle, p.lower[j], p.upper[j], p.largest_rate[j], p.braking[j])
        torque = p.rate_gain[j] * (wanted - rate) + p.integral[j]
        limited = min(max(torque, -p.largest_torque[j]), p.largest_torque[j])
        if (torque - limited) * (wanted - rate) <= 0.0:
            p.integral[j] += p.integral_gain[j] * (wanted - rate) * p.period
        references[j] = rate + limited / p.rate_gain[j]
