"""Kernels of `UnderWay`, whose docstring has the equations."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.records import Record, Vector3

_STEPS = 16
"""Steps of the horizon."""


class BelievedLoop(Record):
    """The attitude loop that is believed, and how many commands it was sent."""

    lag: float  # τ [s]
    rate_gain: float  # κ_r [1/s]
    dead_time: float  # d [s]
    sent: int


class Now(Record):
    """What is known now."""

    attitude: Vector3  # Φ [rad]
    body_rates: Vector3  # Ω [rad/s]
    rotors: Vector3  # force of the rotors in the body over the mass [m/s²]
    outer: Annotated[Array, 2]  # what else accelerates the vehicle along the world's x and y [m/s²]


class Commands(NamedTuple):
    """Ring of K commands."""

    loop: BelievedLoop
    times: Array  # when each was sent, shape (K,) [s]
    upwards: Array  # direction of its thrust, world frame, shape (K, 3)
    now: Now


@kernel
def rates_of_euler(attitude: Array, body_rates: Array) -> tuple[float, float, float]:
    r"""Rates :math:`\dot\Phi = W(\Phi)\,\Omega`: three numbers, infinite or without sense near θ = ±π/2 [rad/s]."""
    cr, sr = math.cos(attitude[0]), math.sin(attitude[0])
    cp, tp = math.cos(attitude[1]), math.tan(attitude[1])
    turning = sr * body_rates[1] + cr * body_rates[2]
    return body_rates[0] + tp * turning, cr * body_rates[1] - sr * body_rates[2], turning / cp


@kernel
def note_sent(commands: Commands, now: float, roll: float, pitch: float, yaw: float) -> None:
    """Take in a command."""
    row = commands.loop.sent % commands.times.shape[0]
    sr, cr = math.sin(roll), math.cos(roll)
    sp, cp = math.sin(pitch), math.cos(pitch)
    sy, cy = math.sin(yaw), math.cos(yaw)
    commands.times[row] = now
    commands.upwards[row, 0] = cy * sp * cr + sy * sr
    commands.upwards[row, 1] = sy * sp * cr - cy * sr
    commands.upwards[row, 2] = cp * cr
    commands.loop.sent += 1


@kernel
def acting_at(commands: Commands, time: float) -> int:
    """Place in the ring of the command that acts at a time: the newest that was sent a dead time ago, or the oldest known."""
    count, size = commands.loop.sent, commands.times.shape[0]
    oldest = max(count - size, 0)
    k = count - 1
    while k > oldest and commands.times[k % size] > time - commands.loop.dead_time + 1e-9:
        k -= 1
    return k


@kernel
def tilt_of(up: Array, sy: float, cy: float) -> tuple[float, float]:
    """Roll and pitch that make the thrust's direction, at a heading."""
    ahead, aside = cy * up[0] + sy * up[1], -sy * up[0] + cy * up[1]
    return -math.asin(min(max(aside, -1.0), 1.0)), math.atan2(ahead, up[2])


@kernel
def carry_ahead(commands: Commands, time: float, horizon: float) -> tuple[float, float, float, float]:
    """By how much position and velocity change along the world's x and y within the horizon, beside what the velocity does."""
    now, loop = commands.now, commands.loop
    x = y = gained_x = gained_y = 0.0
    roll, pitch, yaw = now.attitude[0], now.attitude[1], now.attitude[2]
    roll_rate, pitch_rate, _ = rates_of_euler(now.attitude, now.body_rates)
    sy, cy = math.sin(yaw), math.cos(yaw)
    gain, rate_gain = 1.0 / loop.lag, loop.rate_gain
    step, size = horizon / _STEPS, commands.times.shape[0]
    last, k = loop.sent - 1, acting_at(commands, time)
    to_roll, to_pitch = roll, pitch
    if k >= 0:
        to_roll, to_pitch = tilt_of(commands.upwards[k % size], sy, cy)
    fx, fy, fz = now.rotors[0], now.rotors[1], now.rotors[2]
    for i in range(_STEPS):
        due = time + (i + 0.5) * step - loop.dead_time + 1e-9
        while k < last and commands.times[(k + 1) % size] <= due:
            k += 1
            to_roll, to_pitch = tilt_of(commands.upwards[k % size], sy, cy)
        roll_rate += step * rate_gain * (gain * (to_roll - roll) - roll_rate)
        pitch_rate += step * rate_gain * (gain * (to_pitch - pitch) - pitch_rate)
        roll += step * roll_rate
        pitch += step * pitch_rate
        sr, cr, sp, cp = math.sin(roll), math.cos(roll), math.sin(pitch), math.cos(pitch)
        ahead = cp * fx + sp * sr * fy + sp * cr * fz
        aside = cr * fy - sr * fz
        gained_x += step * (cy * ahead - sy * aside + now.outer[0])
        gained_y += step * (sy * ahead + cy * aside + now.outer[1])
        x += step * gained_x
        y += step * gained_y
    return x, y, gained_x, gained_y
