"""Kernels of `Acting`, on its ring of ticks."""

from __future__ import annotations

import math
from typing import NamedTuple, Self

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.records import Record, Vector3

_MOTOR_LAG = 0.03
"""Usual lag of a rotor's thrust [s]."""
_HALF = 0.02
"""Half of the time over which the gyroscope's change is taken: shorter, and its noise moves a tip of 0.6 m by more than a newton
[s]."""
_ATTITUDE_LASTS = 0.25
"""Time for which the gyroscope's attitude is better than that of the poses: until its bias shows [s]."""


class ActingMemory(Record):
    """What is known beside the ring."""

    ticks: int  # in the ring
    posed: float  # time of the last pose, NaN before [s]
    late: float  # how late the body rates are [s]
    rates: Vector3  # Ω [rad/s]
    force: Vector3  # of the rotors [N]
    attitude: Vector3  # Φ at the last pose [rad]


class Tick(NamedTuple):
    """What is measured at a tick, and the force that was commanded since the one before."""

    body_rates: Array  # Ω, shape (3,) [rad/s]
    arm_angles: Array  # H, shape (n,)
    arm_rates: Array  # Ḣ, shape (n,)
    force: Array  # shape (3,), body frame [N]


class Ring(NamedTuple):
    """Newest ticks, at most K."""

    memory: ActingMemory
    times: Array  # shape (K,) [s]
    turned: Array  # integral of the body rates, shape (K, 3) [rad]
    made: Array  # force of the rotors, shape (K, 3) [N]
    arm_angles: Array  # shape (K, n)
    arm_rates: Array  # shape (K, n)


class Inputs(NamedTuple):
    """Parts of the inputs of `LeafMotion`, in their order."""

    rotors: Array
    attitude: Array
    body_rates: Array
    turning: Array  # rate of the body rates, shape (3,) [rad/s²]
    arm_angles: Array
    arm_rates: Array

    @classmethod
    def of(cls, inputs: Array) -> Self:
        """Views of all inputs together, shape (12 + 2 n,)."""
        rates_at = 6 + inputs.size // 2
        return cls(inputs[:3], inputs[3:6], inputs[6:9], inputs[9:12], inputs[12:rates_at], inputs[rates_at:])


@kernel
def note_tick(ring: Ring, tick: Tick, now: float, arm_age: float) -> None:
    """Take in a tick. Rates that are no numbers go on."""
    memory, k, half = ring.memory, ring.memory.ticks, ring.times.shape[0] // 2
    if k == 2 * half:
        _drop_older(ring, half)
        k = half
    if k > 0:
        passed = now - ring.times[k - 1]
        share = 1.0 - math.exp(-max(passed, 0.0) / _MOTOR_LAG)
        for i in range(3):
            ring.turned[k, i] = ring.turned[k - 1, i] + passed * memory.rates[i]
            memory.force[i] += share * (tick.force[i] - memory.force[i])
    finite = math.isfinite(tick.body_rates[0] + tick.body_rates[1] + tick.body_rates[2])
    for i in range(3):
        memory.rates[i] = tick.body_rates[i] if finite else memory.rates[i]
        ring.made[k, i] = memory.force[i]
    for i in range(ring.arm_angles.shape[1]):
        ring.arm_angles[k, i] = tick.arm_angles[i] + arm_age * tick.arm_rates[i]
        ring.arm_rates[k, i] = tick.arm_rates[i]
    ring.times[k], memory.ticks = now, k + 1


@kernel
def _drop_older(ring: Ring, half: int) -> None:
    ring.times[:half] = ring.times[half:]
    ring.turned[:half] = ring.turned[half:]
    ring.made[:half] = ring.made[half:]
    ring.arm_angles[:half] = ring.arm_angles[half:]
    ring.arm_rates[:half] = ring.arm_rates[half:]


@kernel
def find_inputs(ring: Ring, time: float, seen: Array, inputs: Inputs) -> None:
    """Inputs at the time of a pose, which comes with an attitude."""
    memory = ring.memory
    for i in range(3):
        inputs.attitude[i] = steadied(ring, time, seen, i)
    for i in range(3):
        memory.attitude[i] = inputs.attitude[i]
    memory.posed = time
    late = time + memory.late + _HALF > ring.times[memory.ticks - 1]  # the gyroscope has not gone so far yet
    ahead = 0.0 if late else _HALF
    for i in range(3):
        turned = turned_at(ring, time, i)
        before = turned_at(ring, time - _HALF, i)
        after, first = turned_at(ring, time + ahead, i), turned if not late else before
        last = before if not late else turned_at(ring, time - 2.0 * _HALF, i)
        earlier = turned_at(ring, time - (2.0 if not late else 3.0) * _HALF, i)
        inputs.rotors[i] = value_at(ring, ring.made, time, i)
        inputs.body_rates[i] = (turned - before) / _HALF
        inputs.turning[i] = ((after - first) - (last - earlier)) / (2.0 * _HALF * _HALF)
    for i in range(ring.arm_angles.shape[1]):
        inputs.arm_angles[i] = value_at(ring, ring.arm_angles, time, i)
        inputs.arm_rates[i] = value_at(ring, ring.arm_rates, time, i)


@kernel
def steadied(ring: Ring, time: float, seen: Array, i: int) -> float:
    """One angle at a pose's time: the gyroscope's, which the pose corrects."""
    angle, memory = seen[i], ring.memory
    if i == 2:
        angle += 2.0 * math.pi * round((memory.attitude[2] - angle) / (2.0 * math.pi))  # without jumps at ±π
    if math.isnan(memory.posed):
        return float(angle)
    kept = math.exp(-max(time - memory.posed, 0.0) / _ATTITUDE_LASTS)
    return float(kept * carried(ring, time, i) + (1.0 - kept) * angle)


@kernel
def carried(ring: Ring, time: float, i: int) -> float:
    """One angle of the last pose, turned on by the gyroscope."""
    attitude, posed = ring.memory.attitude, ring.memory.posed
    angle = attitude[i]
    if time == posed:
        return float(angle)
    x = turned_at(ring, time, 0) - turned_at(ring, posed, 0)
    y = turned_at(ring, time, 1) - turned_at(ring, posed, 1)
    z = turned_at(ring, time, 2) - turned_at(ring, posed, 2)
    roll, pitch = attitude[0], attitude[1]
    across = math.sin(roll) * y + math.cos(roll) * z
    if i == 0:
        return float(angle + x + math.tan(pitch) * across)
    if i == 1:
        return float(angle + math.cos(roll) * y - math.sin(roll) * z)
    return float(angle + across / math.cos(pitch))


@kernel
def turned_at(ring: Ring, time: float, i: int) -> float:
    """Integral of a body rate up to a time; beyond the gyroscope's last reading, the last rate goes on."""
    memory = ring.memory
    known = time + memory.late
    beyond = min(max(known - ring.times[memory.ticks - 1], 0.0), memory.late)
    return float(value_at(ring, ring.turned, known, i) + beyond * memory.rates[i])


@kernel
def value_at(ring: Ring, rows: Array, time: float, i: int) -> float:
    """A number of the ticks at another time, the first or last one beyond them."""
    times, last = ring.times, ring.memory.ticks - 1
    k = last
    while k > 0 and times[k] > time:
        k -= 1
    if k == last or time <= times[k]:
        return float(rows[k, i])
    share = (time - times[k]) / (times[k + 1] - times[k])
    return float(rows[k, i] + share * (rows[k + 1, i] - rows[k, i]))


@kernel
def find_now(ring: Ring, attitude: Array, arm_angles: Array) -> None:
    """Φ and H at the last tick."""
    last = ring.memory.ticks - 1
    for i in range(3):
        attitude[i] = carried(ring, ring.times[last], i)
    for i in range(arm_angles.shape[0]):
        arm_angles[i] = ring.arm_angles[last, i]
