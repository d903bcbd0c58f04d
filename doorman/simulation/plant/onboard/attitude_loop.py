r"""The onboard attitude loop, in the structure of a Pixhawk's: attitude P, body rate PID, both at the physics rate.

.. math::
    \Omega_s = \mathrm{sat}(2 K_a \,\mathrm{vec}(q^{-1} q_d) + \Omega_f), \qquad
    \tau = I_A\,(K_p (\Omega_s - \Omega) + z - K_d \dot\Omega) + \Omega \times I_A \Omega, \qquad
    \dot z = K_i (\Omega_s - \Omega)

With feed-forward, :math:`\Omega_f` is the rate of the set point, low-passed, as ArduPilot has it: the loop follows sooner than
its feedback answers a moment. The attitude error is split into tilt and turn about the thrust axis (swing and twist), so that a
large yaw error does not disturb the tilt. The integrator stands still where the rotors are saturated and it would drive them
further.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.dynamics.attitude_loop import USUAL_LAG, AttitudeLoop
from doorman.numba_types.records import Record, Vector3

_QUICKEST, _USUAL_MOTORS = USUAL_LAG, 0.03
"""No loop is quicker than the first with motors whose lag is the second [s]: without feed-forward it would saturate them."""
_DAMPED = 2.0
"""The derivative makes 1 + K_d at least so many times κ_r T for motors of lag T: the rate loop is damped to 0.7."""


@dataclass(frozen=True)
class AttitudeGains:
    """Gains about the body's x, y and z axis, as accelerations: they fit every vehicle whose motors are fast enough."""

    attitude: tuple[float, float, float] = (10.0, 10.0, 4.0)
    """K_a [1/s]."""
    rate: tuple[float, float, float] = (70.0, 70.0, 30.0)
    """K_p [1/s]."""
    integral: tuple[float, float, float] = (70.0, 70.0, 60.0)
    """K_i [1/s²]."""
    derivative: tuple[float, float, float] = (1.5, 1.5, 0.5)
    """K_d [-]."""
    max_rates: tuple[float, float, float] = (3.8, 3.8, 1.0)
    """[rad/s]; yaw is slow because drag torque is small: at this rate the rotors can still stop the turn in time."""
    derivative_cutoff: float = 377.0
    """Bandwidth of the low-pass on dΩ/dt [rad/s]."""
    feed_forward: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Share of the set point's rate that is fed forward,"""
    feed_forward_lag: float = 0.01
    """and the time constant of its low-pass [s]."""
    dead_time: float = 0.0
    """After which a set point of the attitude reaches the loop [s]."""

    @classmethod
    def of(cls, loop: AttitudeLoop, motor_lag: float, overshoot: float | None = None) -> AttitudeGains:
        r"""Gains about x and y of a loop with a lag and a dead time, as of an autopilot tuned for its motors.

        Without motors a step of the attitude overshoots by :math:`e^{-\pi\zeta/\sqrt{1 - \zeta^2}}` with
        :math:`\kappa_r = 4\zeta^2\kappa_a`.

        Args:
            loop: The loop.
            motor_lag: Time constant of the motors [s].
            overshoot: Of a step, as a share of it; the usual shape of `AttitudeLoop` if not given.
        """
        usual, quickest = cls(), _QUICKEST * min(motor_lag / _USUAL_MOTORS, 1.0)
        loop = replace(loop, lag=max(loop.lag, quickest))
        rate_gain = loop.rate_gain if overshoot is None else 4.0 * _damping(overshoot) ** 2 * loop.gain
        soft = loop.feedback > loop.lag
        derivative = max(usual.derivative[0], _DAMPED * rate_gain * motor_lag - 1.0)
        rate = rate_gain * (1.0 + derivative)

        def tilt(value: float, usually: tuple[float, float, float]) -> tuple[float, float, float]:
            return value, value, usually[2]

        return replace(
            usual, attitude=tilt(1.0 / loop.feedback if soft else loop.gain, usual.attitude), rate=tilt(rate, usual.rate),
            integral=tilt(0.1 * rate * loop.gain, usual.integral), derivative=tilt(derivative, usual.derivative),
            dead_time=loop.dead_time, feed_forward=(1.0, 1.0, 0.0) if soft else usual.feed_forward,
            feed_forward_lag=max(loop.lag - 1.0 / rate_gain, usual.feed_forward_lag),
        )  # fmt: skip


def _damping(overshoot: float) -> float:
    """ζ of a loop of second order by the overshoot of a step."""
    if overshoot <= 0.0:
        return 1.0
    decay = -math.log(overshoot)
    return decay / math.hypot(math.pi, decay)


class LoopNumbers(Record):
    """Gains about the body's axes, as in `AttitudeGains`, and what passes in one period."""

    attitude: Vector3
    rate: Vector3
    integral: Vector3
    derivative: Vector3
    max_rates: Vector3  # [rad/s]
    max_integral: Vector3  # largest z [rad/s²]
    feed_forward: Vector3
    period: float  # [s]
    derivative_share: float  # share of the low-pass of dΩ/dt that passes in one,
    feed_forward_share: float  # and of that of the set point's rate


class LoopMemory(Record):
    """What the loop remembers."""

    integral: Vector3  # z [rad/s²]
    rates: Vector3  # last Ω [rad/s]
    acceleration: Vector3  # filtered dΩ/dt [rad/s²]
    rate_errors: Vector3  # [rad/s]
    errors: Vector3  # last attitude errors [rad]
    setpoint_rates: Vector3  # Ω_f [rad/s]


class AttitudeParameters(NamedTuple):
    """Numbers and memory of the attitude kernels."""

    numbers: LoopNumbers
    inertia: Array  # I_A, shape (3, 3) [kg m²]
    memory: LoopMemory
    torque: Array  # result: τ, shape (3,), body frame [N m]

    @classmethod
    def of(
        cls, inertia: ArrayLike, torque_authority: ArrayLike, period: float, gains: AttitudeGains | None = None
    ) -> AttitudeParameters:
        """Parameters for one vehicle, with cleared memory."""
        gains = gains or AttitudeGains()
        matrix = np.array(inertia, dtype=np.float64)
        numbers = LoopNumbers(
            attitude=gains.attitude, rate=gains.rate, integral=gains.integral, derivative=gains.derivative,
            max_rates=gains.max_rates, max_integral=np.asarray(torque_authority) / np.diag(matrix),
            feed_forward=gains.feed_forward, period=period,
            derivative_share=1.0 - math.exp(-period * gains.derivative_cutoff),
            feed_forward_share=1.0 - math.exp(-period * (1.0 / gains.feed_forward_lag)),
        )  # fmt: skip
        return cls(numbers, matrix, LoopMemory(), np.zeros(3))


@kernel
def attitude_error(quaternion: Array, desired: Array) -> tuple[float, float, float]:
    """2 sin(angle/2) of tilt (2) and turn (1) from an attitude to the desired one; quaternions [w, x, y, z], body to world."""
    a, b, c, d = quaternion[0], -quaternion[1], -quaternion[2], -quaternion[3]
    e, f, g, h = desired[0], desired[1], desired[2], desired[3]
    w = a * e - b * f - c * g - d * h
    x = a * f + b * e + c * h - d * g
    y = a * g - b * h + c * e + d * f
    z = a * h + b * g - c * f + d * e
    n = np.sqrt(w * w + z * z)
    if n < 1e-9:  # upside down: any tilt axis rights the vehicle
        return 2.0 * x, 2.0 * y, 0.0
    sign = 1.0 if w >= 0.0 else -1.0
    return 2.0 * (x * w - y * z) / n, 2.0 * (y * w + x * z) / n, 2.0 * sign * z / n


@kernel
def attitude_torque(p: AttitudeParameters, quaternion: Array, rates: Array, desired: Array) -> None:
    """Torque τ of the loop, into `p.torque`."""
    errors, numbers, memory = attitude_error(quaternion, desired), p.numbers, p.memory
    for k in range(3):
        limit, moved = numbers.max_rates[k], (errors[k] - memory.errors[k]) / numbers.period + rates[k]
        memory.errors[k] = errors[k]
        memory.setpoint_rates[k] += numbers.feed_forward_share * (moved - memory.setpoint_rates[k])
        wanted = numbers.attitude[k] * errors[k] + numbers.feed_forward[k] * memory.setpoint_rates[k]
        setpoint = min(max(wanted, -limit), limit)
        slope = (rates[k] - memory.rates[k]) / numbers.period
        memory.acceleration[k] += numbers.derivative_share * (slope - memory.acceleration[k])
        memory.rates[k] = rates[k]
        memory.rate_errors[k] = setpoint - rates[k]
    p.torque[:] = 0.0
    for k in range(3):  # Ω × I_A Ω
        momentum = p.inertia[k, 0] * rates[0] + p.inertia[k, 1] * rates[1] + p.inertia[k, 2] * rates[2]
        p.torque[(k + 1) % 3] += rates[(k + 2) % 3] * momentum
        p.torque[(k + 2) % 3] -= rates[(k + 1) % 3] * momentum
    for k in range(3):
        acceleration = numbers.rate[k] * memory.rate_errors[k] + memory.integral[k]
        acceleration -= numbers.derivative[k] * memory.acceleration[k]
        for i in range(3):
            p.torque[i] += p.inertia[i, k] * acceleration


@kernel
def integrate_rate_error(p: AttitudeParameters, achieved: Array) -> None:
    """Advance the integral z by one period, after the mixer has shared the torque out; of that, (3,), so much is made."""
    numbers, memory = p.numbers, p.memory
    for k in range(3):
        missing = p.torque[k] - achieved[k]
        if missing * memory.rate_errors[k] > 1e-9:
            continue
        bound = numbers.max_integral[k]
        z = memory.integral[k] + numbers.integral[k] * memory.rate_errors[k] * numbers.period
        memory.integral[k] = min(max(z, -bound), bound)
