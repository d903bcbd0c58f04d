"""Kernels of `Acting`, on its ring of ticks."""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.compilation import kernel

COUNT, POSED, RATES, FORCE, ATTITUDE, LATE, MEMORY = 0, 1, 2, 5, 8, 11, 12
"""Places in the memory: ticks in the ring, time of the last pose (NaN before), Ω, force of the rotors, Φ at that pose, and how
late the body rates are [s]."""
TURNED, MADE, ARM = 0, 3, 6
"""Columns of the ring: integral of the rates [rad], force of the rotors [N], then the arm's angles and rates."""

_MOTOR_LAG = 0.03
"""Usual lag of a rotor's thrust [s]."""
_HALF = 0.02
"""Half of the time over which the gyroscope's change is taken: shorter, and its noise moves a tip of 0.6 m by more than a newton
[s]."""
_ATTITUDE_LASTS = 0.25
"""Time for which the gyroscope's attitude is better than that of the poses: until its bias shows [s]."""


@kernel
def note_tick(times: Array, rows: Array, memory: Array, now: float, seen: Array, arm_age: float) -> None:
    """Take in a tick, and what was commanded since the one before: Ω, H, Ḣ and the force. Rates that are no numbers go on."""
    k, n, half = int(memory[COUNT]), (rows.shape[1] - ARM) // 2, times.shape[0] // 2
    if k == 2 * half:
        times[:half] = times[half:]
        rows[:half] = rows[half:]
        k = half
    force = seen[3 + 2 * n :]
    if k > 0:
        passed = now - times[k - 1]
        share = 1.0 - math.exp(-max(passed, 0.0) / _MOTOR_LAG)
        for i in range(3):
            rows[k, TURNED + i] = rows[k - 1, TURNED + i] + passed * memory[RATES + i]
            memory[FORCE + i] += share * (force[i] - memory[FORCE + i])
    finite = math.isfinite(seen[0] + seen[1] + seen[2])
    for i in range(3):
        memory[RATES + i] = seen[i] if finite else memory[RATES + i]
        rows[k, MADE + i] = memory[FORCE + i]
    for i in range(n):
        rows[k, ARM + i] = seen[3 + i] + arm_age * seen[3 + n + i]
        rows[k, ARM + n + i] = seen[3 + n + i]
    times[k], memory[COUNT] = now, k + 1


@kernel
def find_inputs(times: Array, rows: Array, memory: Array, time: float, seen: Array, out: Array) -> None:
    """Inputs at the time of a pose, which comes with an attitude: rotors, Φ, Ω, its rate, arm and its rates."""
    for i in range(3):
        out[3 + i] = steadied(times, rows, memory, time, seen, i)
    for i in range(3):
        memory[ATTITUDE + i] = out[3 + i]
    memory[POSED] = time
    late = time + memory[LATE] + _HALF > times[int(memory[COUNT]) - 1]  # the gyroscope has not gone so far yet
    ahead = 0.0 if late else _HALF
    for i in range(3):
        turned = turned_at(times, rows, memory, time, i)
        before = turned_at(times, rows, memory, time - _HALF, i)
        after, first = turned_at(times, rows, memory, time + ahead, i), turned if not late else before
        last = before if not late else turned_at(times, rows, memory, time - 2.0 * _HALF, i)
        earlier = turned_at(times, rows, memory, time - (2.0 if not late else 3.0) * _HALF, i)
        out[i] = value_at(times, rows, memory, time, MADE + i)
        out[6 + i] = (turned - before) / _HALF
        out[9 + i] = ((after - first) - (last - earlier)) / (2.0 * _HALF * _HALF)
    for i in range(rows.shape[1] - ARM):
        out[12 + i] = value_at(times, rows, memory, time, ARM + i)


@kernel
def steadied(times: Array, rows: Array, memory: Array, time: float, seen: Array, i: int) -> float:
    """One angle at a pose's time: the gyroscope's, which the pose corrects."""
    angle = seen[i]
    if i == 2:
        angle += 2.0 * math.pi * round((memory[ATTITUDE + 2] - angle) / (2.0 * math.pi))  # without jumps at ±π
    if math.isnan(memory[POSED]):
        return float(angle)
    kept = math.exp(-max(time - memory[POSED], 0.0) / _ATTITUDE_LASTS)
    return float(kept * carried(times, rows, memory, time, i) + (1.0 - kept) * angle)


@kernel
def carried(times: Array, rows: Array, memory: Array, time: float, i: int) -> float:
    """One angle of the last pose, turned on by the gyroscope."""
    angle = memory[ATTITUDE + i]
    if time == memory[POSED]:
        return float(angle)
    x = turned_at(times, rows, memory, time, 0) - turned_at(times, rows, memory, memory[POSED], 0)
    y = turned_at(times, rows, memory, time, 1) - turned_at(times, rows, memory, memory[POSED], 1)
    z = turned_at(times, rows, memory, time, 2) - turned_at(times, rows, memory, memory[POSED], 2)
    roll, pitch = memory[ATTITUDE], memory[ATTITUDE + 1]
    across = math.sin(roll) * y + math.cos(roll) * z
    if i == 0:
        return float(angle + x + math.tan(pitch) * across)
    if i == 1:
        return float(angle + math.cos(roll) * y - math.sin(roll) * z)
    return float(angle + across / math.cos(pitch))


@kernel
def turned_at(times: Array, rows: Array, memory: Array, time: float, i: int) -> float:
    """Integral of a body rate up to a time; beyond the gyroscope's last reading, the last rate goes on."""
    last, known = int(memory[COUNT]) - 1, time + memory[LATE]
    beyond = min(max(known - times[last], 0.0), memory[LATE])
    return float(value_at(times, rows, memory, known, TURNED + i) + beyond * memory[RATES + i])


@kernel
def value_at(times: Array, rows: Array, memory: Array, time: float, column: int) -> float:
    """A column at another time, the first or last one beyond them."""
    last = int(memory[COUNT]) - 1
    k = last
    while k > 0 and times[k] > time:
        k -= 1
    if k == last or time <= times[k]:
        return float(rows[k, column])
    share = (time - times[k]) / (times[k + 1] - times[k])
    return float(rows[k, column] + share * (rows[k + 1, column] - rows[k, column]))


@kernel
def find_now(times: Array, rows: Array, memory: Array, out: Array) -> None:
    """Φ and H at the last tick."""
    last = int(memory[COUNT]) - 1
    for i in range(3):
        out[i] = carried(times, rows, memory, times[last], i)
    for i in range(out.shape[0] - 3):
        out[3 + i] = rows[last, ARM + i]
