"""Kernels of `WindFilter`: its prediction, its correction, and what it takes in; its docstring has the equations."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel

Array = NDArray[np.float64]

TURN, HINGE, STATES = 3, 4, 5
"""Places of the wind's turning and of τ in the state [w, ω, τ], and the state's size."""

GUSTS, TURNS = 0.06, 0.01
"""Growth of the deviations of each part of the wind, on the shipped vehicle, and of its turning in a second [N], [rad/s]."""
STEADY = 0.15
"""Weaker wind on that vehicle has no direction that turns [N]."""
_FELT, _FELT_TIME = 0.12, 0.25
"""Noise of what the shipped vehicle feels, and the time after which it is another one [N], [s]."""
_NEAR_NOISE = 3.0
"""By so much less is believed what is felt near the leaf: it may be a touch."""
_BOUND, _BOUND_TIME = 0.3, 0.5
"""Noise of what contact can explain there, and the time after which it is another one [N], [s]."""
_SUDDEN, _JUMP = 0.5, 0.6
"""Noise of the wind where contact is found to be lost, or to be there, and what it is doubted more by where it is lost: it may
have passed for the contact since it jumped. Of the shipped vehicle [N]."""
HINGE_CHANGES = 0.7
"""Change of τ of a room door with the square root of the way [N m/rad^0.5]."""
_MOVED, _MOVED_TIME, _MOVES = 0.2, 0.8, 0.012
"""Noise of the torque that moves such a leaf, the time after which it is another one, and the rate of a leaf that moves [N m],
[s], [rad/s]."""
_SETTLES = 0.6
"""For so long the observer of the outer force settles after take-off [s]."""


class WindMemory(NamedTuple):
    """All that one filter's kernels read and write."""

    state: Array
    """[w, ω, τ], shape (5,)."""
    covariance: Array
    """Shape (5, 5)."""
    flown: Array
    """Time in the air, shape (1,) [s]."""
    scales: Array
    """Of the vehicle's forces, and of the hinge's torques, shape (2,)."""


@kernel
def predict_wind(z: Array, p: Array, time_step: float, steady: float, gusts: float, turns: float) -> None:
    """Turn the wind on by one period."""
    x, y = z[0], z[1]
    c, s = math.cos(z[TURN] * time_step), math.sin(z[TURN] * time_step)
    z[0], z[1] = c * x - s * y, s * x + c * y
    by_turn = time_step if math.hypot(x, y) > steady else 0.0
    to_x, to_y = -by_turn * z[1], by_turn * z[0]
    for k in range(STATES):
        a, b, turn = p[0, k], p[1, k], p[TURN, k]
        p[0, k], p[1, k] = c * a - s * b + to_x * turn, s * a + c * b + to_y * turn
    for k in range(STATES):
        a, b, turn = p[k, 0], p[k, 1], p[k, TURN]
        p[k, 0], p[k, 1] = c * a - s * b + to_x * turn, s * a + c * b + to_y * turn
    for k in range(3):
        p[k, k] += time_step * gusts
    p[TURN, TURN] += time_step * turns


@kernel
def correct_wind(z: Array, p: Array, x: float, y: float, up: float, torque: float, off: float, noise: float) -> None:
    """Kalman's step for one number."""
    variance = noise
    spread = (
        p[0, 0] * x + p[0, 1] * y + p[0, 2] * up + p[0, 4] * torque,
        p[1, 0] * x + p[1, 1] * y + p[1, 2] * up + p[1, 4] * torque,
        p[2, 0] * x + p[2, 1] * y + p[2, 2] * up + p[2, 4] * torque,
        p[3, 0] * x + p[3, 1] * y + p[3, 2] * up + p[3, 4] * torque,
        p[4, 0] * x + p[4, 1] * y + p[4, 2] * up + p[4, 4] * torque,
    )
    variance += x * spread[0] + y * spread[1] + up * spread[2] + torque * spread[4]
    for k in range(STATES):
        z[k] += spread[k] / variance * off
        for j in range(STATES):
            p[k, j] -= spread[k] / variance * spread[j]


@kernel
def wind_doubt(covariance: Array, direction: tuple[float, float, float]) -> float:
    """Standard deviation of the wind along a direction [N]."""
    variance = 0.0
    for k in range(3):
        for j in range(3):
            variance += direction[k] * covariance[k, j] * direction[j]
    return math.sqrt(max(variance, 0.0))


@kernel
def advance_wind(wind: WindMemory, time_step: float) -> None:
    """Advance by one period."""
    wind.flown[0] += time_step
    force = wind.scales[0]
    predict_wind(wind.state, wind.covariance, time_step, force * STEADY, (force * GUSTS) ** 2, TURNS**2)


@kernel
def take_for_wind(wind: WindMemory, felt: Array, noise: float) -> None:
    """Take in that all of the outer force is wind, with this variance."""
    for k in range(3):
        x, y, up = (1.0 if k == 0 else 0.0), (1.0 if k == 1 else 0.0), (1.0 if k == 2 else 0.0)
        correct_wind(wind.state, wind.covariance, x, y, up, 0.0, felt[k] - wind.state[k], noise)


@kernel
def feel_wind(wind: WindMemory, felt: Array, near: bool, time_step: float) -> None:
    """Take in what is felt in free flight."""
    if wind.flown[0] >= _SETTLES and time_step > 0.0:
        noise = (wind.scales[0] * _FELT) ** 2 * (_NEAR_NOISE**2 if near else 1.0)
        take_for_wind(wind, felt, noise * max(_FELT_TIME / time_step, 1.0))


@kernel
def take_tip_force(
    wind: WindMemory, normal: tuple[float, float, float], force: float, noise: float, offset: float, time_step: float
) -> None:
    """Take in the wind along the normal from the tip's force, which a sensor reads in contact.

    An offset of the sensor does not average out: with a density of its variance squared over the wind's growth, the filter's own
    variance ends at the offset's.
    """
    if wind.flown[0] >= _SETTLES and time_step > 0.0:
        z, (x, y, up), scale = wind.state, normal, wind.scales[0]
        density = (scale * _FELT) ** 2 * _FELT_TIME + (offset / (scale * GUSTS)) ** 2
        off = force - (x * z[0] + y * z[1] + up * z[2])
        correct_wind(z, wind.covariance, x, y, up, 0.0, off, noise + density / time_step)


@kernel
def lose_contact(wind: WindMemory, felt: Array) -> None:
    """Take in that there is no contact: what is felt is wind."""
    for k in range(3):
        wind.covariance[k, k] += (wind.scales[0] * _JUMP) ** 2
    take_for_wind(wind, felt, (wind.scales[0] * _SUDDEN) ** 2)


@kernel
def meet_contact(wind: WindMemory, x: float, y: float, up: float, more: float) -> None:
    """Take in that the tip presses harder along a direction than the wind seemed to say [N]."""
    correct_wind(wind.state, wind.covariance, x, y, up, 0.0, more, (wind.scales[0] * _SUDDEN) ** 2)


@kernel
def take_unexplained(wind: WindMemory, x: float, y: float, up: float, force: float, time_step: float) -> None:
    """Take in a part of what the tip seems to feel that no contact makes."""
    if force != 0.0 and time_step > 0.0:
        noise = (wind.scales[0] * _BOUND) ** 2 * max(_BOUND_TIME / time_step, 1.0)
        correct_wind(wind.state, wind.covariance, x, y, up, 0.0, -force, noise)


@kernel
def take_push(
    wind: WindMemory, normal: tuple[float, float, float], levers: float, torque: float, opening: float, closer: float,
    time_step: float,
) -> None:  # fmt: skip
    """Take in what the rotors turn the leaf with. One that stands bears that much, or more.

    The torque of the hinge grows by the closer's known stiffness on the way, and by chance beside that.
    """
    if time_step <= 0.0:
        return
    wind.state[HINGE] += closer * opening * time_step
    z, (x, y, up) = wind.state, normal
    wind.covariance[HINGE, HINGE] += (wind.scales[1] * HINGE_CHANGES) ** 2 * abs(opening) * time_step
    off = torque - (-levers * (x * z[0] + y * z[1] + up * z[2]) + z[HINGE])
    if opening > _MOVES or off > 0.0:
        noise = (wind.scales[1] * _MOVED) ** 2 * max(_MOVED_TIME / time_step, 1.0)
        correct_wind(z, wind.covariance, -levers * x, -levers * y, -levers * up, 1.0, off, noise)
