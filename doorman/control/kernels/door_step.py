"""Kernels of `DoorFilter`: one period of it, and the hinge's parameters as they are known; its docstring has the equations."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.control.kernels.leaf import OPENS, PER_ANGLE, leaf_normal, leaf_weight

Array = NDArray[np.float64]

ANGLE, RATE, TORQUE, DAMPING, FRICTION, STIFFNESS, INERTIA, WIND_X, WIND_Y = range(9)
"""Places in the state."""
STATES = 9
(
    LEVER, VEHICLE_INERTIA, REST, PRELOAD, LIGHTEST, HEAVIEST, TORQUE_TIME, ANGLE_NOISE, PUSH_IN_WIND, TORQUE_IN_WIND,
    TYPICAL_WIND, WIND_DEVIATION, WIND_SHARE, WIND_LEVER, CLOSES, END, NUMBERS,
) = range(17)  # fmt: skip
"""Places in the numbers: constants of the model and of `[estimation]`; `CLOSES` is 1 or −1, the sense in which torques shut,
`END` the lower limit of α."""
SEEN, TOUCHED, PUSH_NOISE, TORQUE_DEVIATION, STOOD, SEALED, MEMORY = range(7)
"""Places in the memory: time of the last measurement, whether the leaf has been touched, noises, which wind adds to, whether the
leaf stood, and where a seal held it (−∞ without)."""


class DoorMemory(NamedTuple):
    """All that one filter's kernels read and write."""

    numbers: Array
    """Shape (NUMBERS,)."""
    leaf: Array
    """What `leaf_numbers` returns."""
    memory: Array
    """Shape (MEMORY,)."""
    state: Array
    """z, shape (9,)."""
    covariance: Array
    """Shape (9, 9)."""
    work: Array
    """Scratch, shape (2, 9)."""
    hinge: Array
    """What `hinge_of` finds, shape (12,)."""


_MOVING = 0.02
"""Slower than this the door counts as standing [rad/s]."""
_LONGEST_STEP = 0.02
"""A longer period, of a controller that was held up, is followed in parts [s]."""
_STUCK_RATE = 8.0
"""Bandwidth with which a standing door's angle is followed [rad/s]."""
_STUCK_ANGLE, _STUCK_SPEED = 0.002, 0.01
"""Deviations of angle and rate that are followed so, where they do not lag [rad], [rad/s]."""
_SEAL, _UNSEALED = 2.0, 0.05
"""A leaf that comes loose under more than its hinge should resist with, by so many deviations, is sealed or latched. For so far
what it resists with says nothing of the hinge [rad]."""
_PAST_ITS_END = 0.05
"""A tip that is farther beyond the joint's range is beside the leaf, and not before it [rad]."""
_FELT = 0.1
"""Wind that says where it comes from [N]."""


@kernel
def advance_door(
    numbers: Array, leaf: Array, memory: Array, z: Array, p: Array, work: Array, push: float, touching: bool,
    tip_angle: float, measured_at: float, now: float, time_step: float, wind_x: float, wind_y: float,
) -> None:  # fmt: skip
    """One period of the filter.

    Args:
        numbers: Constants, shape (NUMBERS,).
        leaf: What `leaf_numbers` returns.
        memory: Shape (MEMORY,), written to.
        z: State, shape (9,), written to.
        p: Covariance, shape (9, 9), written to.
        work: Scratch, shape (2, 9).
        push: F_n [N].
        touching: Whether the tip is on the leaf.
        tip_angle: Angle of the tip about the hinge [rad].
        measured_at: When it was true [s].
        now: [s].
        time_step: Since the last call [s].
        wind_x: On the vehicle before the first touch [N].
        wind_y: Its other level component [N].
    """
    if touching and memory[TOUCHED] == 0.0:
        memory[TOUCHED] = 1.0
        expect_wind(numbers, memory, z, p, wind_x, wind_y)
    if touching and abs(z[RATE]) < _MOVING:
        memory[STOOD] = 1.0
        follow_standing(z, p, tip_angle, now - measured_at, time_step)
        return
    if not touching and z[RATE] == 0.0 and friction_holds(numbers, leaf, z):
        return
    felt = push if touching else 0.0
    come_loose(numbers, leaf, memory, z, p, felt)
    predict_door(numbers, leaf, memory, z, p, work, felt, touching, time_step)
    if touching and measured_at > memory[SEEN]:
        correct_door(numbers, memory, z, p, work, tip_angle, now - measured_at)
    memory[SEEN] = measured_at


@kernel
def expect_wind(numbers: Array, memory: Array, z: Array, p: Array, wind_x: float, wind_y: float) -> None:
    """Expect wind on the leaf, and gusts, as the wind on the vehicle makes them likely.

    Args:
        numbers: Constants of the filter, shape (NUMBERS,).
        memory: Of the filter, shape (MEMORY,); its noises grow.
        z: State, shape (STATES,); its wind is set.
        p: Covariance of the state, shape (STATES, STATES); its torque and wind are changed.
        wind_x: Force of the wind on the vehicle along the world's x axis [N].
        wind_y: Force of the wind on the vehicle along the world's y axis [N].
    """
    strength = math.hypot(wind_x, wind_y)
    memory[PUSH_NOISE] += numbers[PUSH_IN_WIND] * strength
    memory[TORQUE_DEVIATION] += numbers[TORQUE_IN_WIND] * strength
    p[TORQUE, TORQUE] = memory[TORQUE_DEVIATION] ** 2
    if strength > 0.0:
        mean = numbers[TYPICAL_WIND] + numbers[WIND_SHARE] * (strength - numbers[TYPICAL_WIND])
        share = min(strength / _FELT, 1.0) / strength
        x, y, variance = share * wind_x, share * wind_y, numbers[WIND_DEVIATION] ** 2
        z[WIND_X], z[WIND_Y] = mean * x, mean * y
        p[WIND_X, WIND_X] += variance * x * x
        p[WIND_X, WIND_Y] += variance * x * y
        p[WIND_Y, WIND_X] += variance * y * x
        p[WIND_Y, WIND_Y] += variance * y * y


@kernel
def friction_holds(numbers: Array, leaf: Array, z: Array) -> bool:
    """Whether friction holds a free door that stands.

    Args:
        numbers: Constants of the filter, shape (NUMBERS,).
        leaf: Of the door, see `leaf_numbers`, shape (17,).
        z: State, shape (STATES,).
    """
    known = numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE])
    return bool(z[FRICTION] > abs(z[STIFFNESS] * (z[ANGLE] - numbers[REST])) + abs(known))


@kernel
def follow_standing(z: Array, p: Array, tip_angle: float, age: float, time_step: float) -> None:
    """Follow the tip on a standing door, and leave the parameters alone.

    Where the door comes loose, angle and rate lag behind, and as much as they lag they are uncertain together; to take
    the rate's lag for motion would make the leaf light. The tip's angle is that of `age` ago besides.

    Args:
        z: State, shape (STATES,), changed.
        p: Covariance of the state, shape (STATES, STATES), changed.
        tip_angle: Measured α of the tip [rad].
        age: Of the measurement [s].
        time_step: Of the period [s].
    """
    parts = math.ceil(time_step / _LONGEST_STEP)
    step, off = time_step / parts, 0.0
    for _ in range(parts):
        off = tip_angle - z[ANGLE]
        z[ANGLE] += step * (z[RATE] + 2.0 * _STUCK_RATE * off)
        z[RATE] += step * _STUCK_RATE**2 * off
    lag = abs(off)
    lag_of_rate = 2.0 * _STUCK_RATE * lag
    lag_of_angle, old = lag + age * lag_of_rate, age * _STUCK_SPEED
    for row in range(RATE + 1):
        for column in range(STATES):
            p[row, column] = p[column, row] = 0.0
    p[ANGLE, ANGLE] = lag_of_angle**2 + _STUCK_ANGLE**2 + old**2
    p[RATE, RATE] = lag_of_rate**2 + _STUCK_SPEED**2
    p[ANGLE, RATE] = p[RATE, ANGLE] = lag_of_angle * lag_of_rate + old * _STUCK_SPEED


@kernel
def come_loose(numbers: Array, leaf: Array, memory: Array, z: Array, p: Array, push: float) -> None:
    """Notice a seal as the leaf begins to move, and notice the end of the seal.

    Args:
        numbers: Constants of the filter, shape (NUMBERS,).
        leaf: Of the door, see `leaf_numbers`, shape (17,).
        memory: Of the filter, shape (MEMORY,), changed.
        z: State, shape (STATES,), changed.
        p: Covariance of the state, shape (STATES, STATES), changed.
        push: Force of the tip along the normal, positive where it presses [N].
    """
    if memory[STOOD] != 0.0:
        memory[STOOD] = 0.0
        known = numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE])
        bears = abs(numbers[LEVER] * push + known + z[STIFFNESS] * (z[ANGLE] - numbers[REST]))
        deviation = math.sqrt(max(p[FRICTION, FRICTION], 0.0))
        if bears > z[FRICTION] + _SEAL * deviation + memory[TORQUE_DEVIATION]:
            memory[SEALED] = z[ANGLE]
            p[TORQUE, TORQUE] = bears**2
    elif math.isfinite(memory[SEALED]) and abs(z[ANGLE] - memory[SEALED]) > _UNSEALED:
        memory[SEALED], z[TORQUE] = -math.inf, 0.0
        for k in range(STATES):
            p[TORQUE, k] = p[k, TORQUE] = 0.0
        p[TORQUE, TORQUE] = memory[TORQUE_DEVIATION] ** 2


@kernel
def predict_door(
    numbers: Array, leaf: Array, memory: Array, z: Array, p: Array, work: Array, push: float, touching: bool,
    time_step: float,
) -> None:  # fmt: skip
    r"""Move the state on by the model, and its covariance by :math:`A P A^T + Q`; A differs from 1 in three rows.

    Args:
        numbers: Constants of the filter, shape (NUMBERS,).
        leaf: Of the door, see `leaf_numbers`, shape (17,).
        memory: Of the filter, shape (MEMORY,).
        z: State, shape (STATES,), changed.
        p: Covariance of the state, shape (STATES, STATES), changed.
        work: Scratch, shape (2 or more, STATES).
        push: Force of the tip along the normal, positive where it presses [N].
        touching: Whether the tip touches the leaf.
        time_step: Of the period [s].
    """
    lever, inertia, x, y = numbers[LEVER], z[INERTIA], 0.0, 0.0
    if touching:
        inertia += numbers[VEHICLE_INERTIA]
    slip = math.tanh(z[RATE] / (0.5 * _MOVING))
    x, y, _ = leaf_normal(leaf, z[ANGLE])
    x, y = numbers[WIND_LEVER] * x, numbers[WIND_LEVER] * y
    off = z[ANGLE] - numbers[REST]
    torque = z[DAMPING] * z[RATE] + z[FRICTION] * slip + z[STIFFNESS] * off + z[TORQUE]
    torque += numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE]) + x * z[WIND_X] + y * z[WIND_Y]
    acceleration = -(lever * push + torque) / inertia
    fade, share = math.exp(-time_step / numbers[TORQUE_TIME]), time_step / inertia
    stiff = z[FRICTION] * (1.0 - slip * slip) / (0.5 * _MOVING)
    row = work[0]
    row[ANGLE], row[TORQUE], row[DAMPING], row[FRICTION] = (
        -share * z[STIFFNESS],
        -share,
        -share * z[RATE],
        -share * slip,
    )
    row[RATE] = 1.0 - time_step * min((z[DAMPING] + stiff) / inertia, 0.5 / time_step)
    row[STIFFNESS], row[INERTIA], row[WIND_X], row[WIND_Y] = -share * off, -share * acceleration, -share * x, -share * y
    move_covariance(p, row, work[1], time_step, fade)
    p[RATE, RATE] += time_step * (memory[PUSH_NOISE] * lever / inertia) ** 2
    p[TORQUE, TORQUE] += (1.0 - fade**2) * memory[TORQUE_DEVIATION] ** 2
    rate = z[RATE] + time_step * acceleration
    z[ANGLE] += time_step * z[RATE]
    if not touching and (rate * z[RATE] <= 0.0 or abs(rate) < 0.5 * _MOVING) and friction_holds(numbers, leaf, z):
        rate = 0.0  # friction stops a free door, it does not drive it back
    z[RATE] = rate
    stop_where_closed(numbers, leaf, z)
    z[TORQUE] *= fade


@kernel
def move_covariance(p: Array, row: Array, moved: Array, time_step: float, fade: float) -> None:
    r""":math:`A P A^T` in place, with the rows of A: angle and rate times the step, `row` for the rate, `fade` for the torque.

    Args:
        p: Covariance of the state, shape (STATES, STATES), changed.
        row: Of A for the rate, shape (STATES,).
        moved: Scratch, shape (STATES,).
        time_step: Of the period [s].
        fade: Entry of A for the torque, in (0, 1].
    """
    for column in range(STATES):
        total = 0.0
        for k in range(STATES):
            total += row[k] * p[k, column]
        p[ANGLE, column] += time_step * p[RATE, column]
        p[RATE, column] = total
        p[TORQUE, column] *= fade
    for k in range(STATES):
        total = 0.0
        for column in range(STATES):
            total += p[k, column] * row[column]
        moved[k] = total
    for k in range(STATES):
        p[k, ANGLE] += time_step * p[k, RATE]
        p[k, RATE] = moved[k]
        p[k, TORQUE] *= fade


@kernel
def pass_leaf(numbers: Array, z: Array, tip_angle: float) -> None:
    """Put a leaf that is not touched beyond the tip, wherever it was thought to be."""
    end = numbers[END]
    if end - _PAST_ITS_END < tip_angle < z[ANGLE]:
        z[ANGLE] = max(tip_angle, end)
        z[RATE] = min(z[RATE], 0.0)


@kernel
def stop_where_closed(numbers: Array, leaf: Array, z: Array) -> None:
    """Stop a door that its closer or its weight presses shut where it is closed.

    Args:
        numbers: Constants of the filter, shape (NUMBERS,).
        leaf: Of the door, see `leaf_numbers`, shape (17,).
        z: State, shape (STATES,), changed.
    """
    known = numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE])
    if known != 0.0 and leaf[OPENS] * leaf[PER_ANGLE] * (z[ANGLE] - 0.5 * math.pi) < 0.0:
        z[ANGLE], z[RATE] = 0.5 * math.pi, 0.0


@kernel
def correct_door(numbers: Array, memory: Array, z: Array, p: Array, work: Array, tip_angle: float, age: float) -> None:
    """Correct the state by the angle as it was `age` ago, in Joseph's form, which holds for any gain.

    Args:
        numbers: Constants of the filter, shape (NUMBERS,).
        memory: Of the filter, shape (MEMORY,).
        z: State, shape (STATES,), changed.
        p: Covariance of the state, shape (STATES, STATES), changed.
        work: Scratch, shape (2 or more, STATES).
        tip_angle: Measured α of the tip [rad].
        age: Of the measurement [s].
    """
    spread, gain, noise = work[0], work[1], numbers[ANGLE_NOISE] ** 2
    for k in range(STATES):
        spread[k] = p[k, ANGLE] - age * p[k, RATE]
    variance = spread[ANGLE] - age * spread[RATE] + noise
    off = tip_angle - (z[ANGLE] - age * z[RATE])
    for k in range(STATES):
        gain[k] = 0.0 if k > TORQUE and math.isfinite(memory[SEALED]) else spread[k] / variance
        z[k] += gain[k] * off
    for k in range(DAMPING, INERTIA):
        z[k] = max(z[k], 0.0)
    z[INERTIA] = min(max(z[INERTIA], numbers[LIGHTEST]), numbers[HEAVIEST])
    for column in range(STATES):
        seen = p[ANGLE, column] - age * p[RATE, column]
        for k in range(STATES):
            p[k, column] -= gain[k] * seen
    for k in range(STATES):
        seen = p[k, ANGLE] - age * p[k, RATE]
        for column in range(STATES):
            p[k, column] += gain[column] * (noise * gain[k] - seen)
    for k in range(STATES):
        for column in range(k):
            p[k, column] = p[column, k] = 0.5 * (p[k, column] + p[column, k])


@kernel
def hinge_of(numbers: Array, leaf: Array, z: Array, p: Array, out: Array) -> None:
    """Parameters of the hinge in the order of `HingeEstimate`, into `out` of shape (12,).

    Args:
        numbers: Constants of the filter, shape (NUMBERS,).
        leaf: Of the door, see `leaf_numbers`, shape (17,).
        z: State, shape (STATES,).
        p: Covariance of the state, shape (STATES, STATES).
        out: Filled in SI units, shape (12,).
    """
    known = abs(numbers[PRELOAD] + leaf_weight(leaf, z[ANGLE]))
    turned = abs(numbers[REST] - z[ANGLE])
    squares = p[FRICTION, FRICTION] + turned * turned * p[STIFFNESS, STIFFNESS]
    together = 2.0 * turned * p[FRICTION, STIFFNESS]
    for k in range(DAMPING, INERTIA + 1):
        out[k - DAMPING] = z[k]
        out[k - DAMPING + 4] = math.sqrt(max(p[k, k], 0.0))
    x, y, _ = leaf_normal(leaf, z[ANGLE])
    out[8] = math.sqrt(max(squares + together, 0.0))
    out[9] = numbers[CLOSES] * numbers[WIND_LEVER] * (x * z[WIND_X] + y * z[WIND_Y])
    out[10] = z[FRICTION] - known - z[STIFFNESS] * turned
    out[11] = math.sqrt(max(squares - together, 0.0))
