r"""What a force sensor in the tip says: its offset is learnt in free flight, and in contact it tells wind from push.

The outer force is felt with the lag of the vehicle's observer: three poles at ω from positions of the age t. A reading passes
three poles of the same mean delay, :math:`1/\omega + t/3` each, before both are compared. Whether the tip touches is told by the
first of them, which only smooths.
"""

from __future__ import annotations

import math

from doorman.compilation import kernel
from doorman.control.kernels.leaf_estimator.forces import along, pull
from doorman.control.kernels.leaf_estimator.memory import (
    OFFSET,
    OFFSET_VARIANCE,
    READING_NOISE,
    READS,
    VEHICLE_RATE,
    LeafMemory,
)
from doorman.control.kernels.vehicle_step import LATE, LATEST, OUTER_FORCE
from doorman.control.kernels.wind_step import feel_wind, take_tip_force

_POLES = 3
_ELSEWHERE = 4.0
"""A reading in free flight that is so many deviations off a known offset is a bump, as of a tip that feels for the frame."""


@kernel
def take_reading(e: LeafMemory, reading: float, time_step: float) -> None:
    """Smooth a reading, less the offset; NaN stands for none."""
    reads = e.memory[READS : READS + _POLES]
    if math.isnan(reading):
        for k in range(_POLES):
            reads[k] = math.nan
        return
    late, value = e.vehicle[LATE], reading - e.memory[OFFSET]
    rate = min(e.numbers[VEHICLE_RATE], LATEST / late) if late > 0.0 else e.numbers[VEHICLE_RATE]
    share = 1.0 - math.exp(-time_step / (1.0 / rate + late / _POLES))
    for k in range(_POLES):
        reads[k] = value if math.isnan(reads[k]) else reads[k] + share * (value - reads[k])
        value = reads[k]


@kernel
def is_read(e: LeafMemory) -> bool:
    """Whether the sensor says something."""
    return not math.isnan(e.memory[READS])


@kernel
def presses(e: LeafMemory, normal: tuple[float, float, float]) -> float:
    """Force of the tip along the normal: as it is read, or else wind less outer force [N]."""
    if is_read(e):
        return float(e.memory[READS])
    return pull(normal, e.wind.state, e.vehicle[OUTER_FORCE : OUTER_FORCE + 3])


@kernel
def learn_offset(e: LeafMemory, reading: float) -> None:
    """Take in a reading of a tip that is far from everything: all of it is offset and noise."""
    memory, noise = e.memory, e.numbers[READING_NOISE] ** 2
    off = reading - memory[OFFSET]
    if memory[OFFSET_VARIANCE] < noise and abs(off) > _ELSEWHERE * math.sqrt(noise):
        return
    gain = memory[OFFSET_VARIANCE] / (memory[OFFSET_VARIANCE] + noise)
    memory[OFFSET] += gain * off
    memory[OFFSET_VARIANCE] *= 1.0 - gain
    for k in range(_POLES):
        memory[READS + k] = 0.0


@kernel
def feel_beside(e: LeafMemory, normal: tuple[float, float, float], time_step: float) -> None:
    """Take in the wind without contact: of the outer force, what the tip does not press with; near the leaf, too."""
    felt = e.tip[:3]
    for k in range(3):
        felt[k] = e.vehicle[OUTER_FORCE + k] + normal[k] * e.memory[READS + _POLES - 1]
    feel_wind(e.wind, felt, False, time_step)


@kernel
def tell_wind(e: LeafMemory, normal: tuple[float, float, float], time_step: float) -> None:
    """Take in the wind along the normal: the outer force and what the tip presses with, both as late."""
    wind = along(normal, e.vehicle[OUTER_FORCE : OUTER_FORCE + 3]) + e.memory[READS + _POLES - 1]
    take_tip_force(e.wind, normal, wind, e.numbers[READING_NOISE] ** 2, e.memory[OFFSET_VARIANCE], time_step)
