"""Kernels of `UnderWay`, whose docstring has the equations."""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.compilation import kernel

SENT, UP, ROW = 0, 1, 4
"""Places in a row of the ring: when a command was sent, and the direction of its thrust, world frame."""
COUNT, LAG, RATE_GAIN, DEAD_TIME, NUMBERS = range(5)
"""Places in the numbers: commands so far, τ, κ_r and d."""
NOW, AHEAD, ATTITUDE, RATES, FORCE, STEADY, GIVEN = 0, 1, 2, 5, 8, 11, 13
"""Places in what is given: time, horizon, Φ, Ω, force of the rotors in the body over the mass, and what else accelerates the
vehicle along the world's x and y."""
_STEPS = 16
"""Steps of the horizon."""


@kernel
def rates_of_euler(attitude: Array, body_rates: Array) -> tuple[float, float, float]:
    r"""Rates :math:`\dot\Phi = W(\Phi)\,\Omega`: three numbers, infinite or without sense near θ = ±π/2 [rad/s]."""
    cr, sr = math.cos(attitude[0]), math.sin(attitude[0])
    cp, tp = math.cos(attitude[1]), math.tan(attitude[1])
    turning = sr * body_rates[1] + cr * body_rates[2]
    return body_rates[0] + tp * turning, cr * body_rates[1] - sr * body_rates[2], turning / cp


@kernel
def note_sent(ring: Array, numbers: Array, now: float, attitude: Array) -> None:
    """Take in a command."""
    row = int(numbers[COUNT]) % ring.shape[0]
    sr, cr = math.sin(attitude[0]), math.cos(attitude[0])
    sp, cp = math.sin(attitude[1]), math.cos(attitude[1])
    sy, cy = math.sin(attitude[2]), math.cos(attitude[2])
    ring[row, SENT] = now
    ring[row, UP] = cy * sp * cr + sy * sr
    ring[row, UP + 1] = sy * sp * cr - cy * sr
    ring[row, UP + 2] = cp * cr
    numbers[COUNT] += 1.0


@kernel
def acting_at(ring: Array, numbers: Array, time: float) -> int:
    """Place in the ring of the command that acts at a time: the newest that was sent a dead time ago, or the oldest known."""
    count, size = int(numbers[COUNT]), ring.shape[0]
    oldest = max(count - size, 0)
    k = count - 1
    while k > oldest and ring[k % size, SENT] > time - numbers[DEAD_TIME] + 1e-9:
        k -= 1
    return k


@kernel
def tilt_of(up: Array, sy: float, cy: float) -> tuple[float, float]:
    """Roll and pitch that make the thrust's direction, at a heading."""
    ahead, aside = cy * up[0] + sy * up[1], -sy * up[0] + cy * up[1]
    return -math.asin(min(max(aside, -1.0), 1.0)), math.atan2(ahead, up[2])


@kernel
def carry_ahead(ring: Array, numbers: Array, given: Array, out: Array) -> None:
    """By how much position and velocity change along the world's x and y within the horizon, beside what the velocity does."""
    for k in range(4):
        out[k] = 0.0
    roll, pitch, yaw = given[ATTITUDE], given[ATTITUDE + 1], given[ATTITUDE + 2]
    roll_rate, pitch_rate, _ = rates_of_euler(given[ATTITUDE:RATES], given[RATES:FORCE])
    sy, cy = math.sin(yaw), math.cos(yaw)
    gain, rate_gain = 1.0 / numbers[LAG], numbers[RATE_GAIN]
    step, size = given[AHEAD] / _STEPS, ring.shape[0]
    last, k = int(numbers[COUNT]) - 1, acting_at(ring, numbers, given[NOW])
    to_roll, to_pitch = roll, pitch
    if k >= 0:
        to_roll, to_pitch = tilt_of(ring[k % size, UP:ROW], sy, cy)
    fx, fy, fz = given[FORCE], given[FORCE + 1], given[FORCE + 2]
    for i in range(_STEPS):
        due = given[NOW] + (i + 0.5) * step - numbers[DEAD_TIME] + 1e-9
        while k < last and ring[(k + 1) % size, SENT] <= due:
            k += 1
            to_roll, to_pitch = tilt_of(ring[k % size, UP:ROW], sy, cy)
        roll_rate += step * rate_gain * (gain * (to_roll - roll) - roll_rate)
        pitch_rate += step * rate_gain * (gain * (to_pitch - pitch) - pitch_rate)
        roll += step * roll_rate
        pitch += step * pitch_rate
        sr, cr, sp, cp = math.sin(roll), math.cos(roll), math.sin(pitch), math.cos(pitch)
        ahead = cp * fx + sp * sr * fy + sp * cr * fz
        aside = cr * fy - sr * fz
        out[2] += step * (cy * ahead - sy * aside + given[STEADY])
        out[3] += step * (sy * ahead + cy * aside + given[STEADY + 1])
        out[0] += step * out[2]
        out[1] += step * out[3]
