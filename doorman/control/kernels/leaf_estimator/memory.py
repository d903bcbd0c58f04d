"""Memory of `LeafEstimator`: places in its numbers, memory and result."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.control.kernels.door_filter.memory import DoorMemory
from doorman.control.kernels.wind_step import WindMemory
from doorman.kinematics.vehicles.arms.arm import ArmParameters

Array = NDArray[np.float64]

(
    MASS, LEVER, VEHICLE_RATE, GOAL, REST, START, MOST_RESISTANCE, ANGLE_DEVIATION, LEVERS, CLOSER, AHEAD, UP,
    FORCE_SCALE, TORQUE_SCALE, TIME_SCALE, HINGE_SCALE, SHUT, READING_NOISE, NUMBERS,
) = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 14, 15, 16, 17, 18, 19, 20  # fmt: skip
"""Places in the numbers: m_A, D_V, ω of the vehicle's observer, α of goal, spring at rest and start, torque of the largest push,
deviation of the tip's way at the start, levers of the wind on vehicle and leaf together, the closer's torque, sense of α towards
the goal, the door's axis,
the scales of the vehicle's forces, torques and times, and of the hinge's torques; α beyond which the frame stops the leaf; and
the noise of the tip's force sensor."""
(
    TOUCHED_AT, STOOD, SOUGHT, DEEPEST, GHOST, RESISTS, HAS_MOVED, MORE, FACE, FACE_VARIANCE, CLOSED, MET, MEASURED, YAW,
    SLID, LAST, READS, OFFSET, OFFSET_VARIANCE, OPENED, MEMORY,
) = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 16, 17, 20, 21, 22, 23  # fmt: skip
"""Places in the memory: time of the touch, α where the leaf stood, whether it was sought, α that the tip came to, how much
momentum the leaf seems to get from nothing, what the hinge resists with, whether that was seen in motion, and more while it
sticks; where the face stands, with its variance, whether the leaf is closed, where it was met, NaN before, and for how long it
was measured; heading without jumps; the force of the tip on the face; when it last touched; of its sensor the reading, smoothed
once, twice and three times, NaN without one, the offset, and its variance; and with what opening rate the tip came last."""
(
    AT, MOVES, ATTITUDE_NOW, ATTITUDE_RATES, WIND_NOW, FRICTION_FORCE, DOOR_ANGLE, DOOR_RATE, TOUCHES, NORMAL_FORCE, RESISTANCE,
    FRICTION_SHARE, DOOR_INERTIA, FACE_OFFSET, NORMAL_PULL, FOUND_SIZE,
) = 0, 3, 6, 9, 12, 15, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26  # fmt: skip
"""Places in what is found: `LeafEstimate`'s fields."""
FOUND, SINGULAR, NOT_FINITE = range(3)
"""How a period ended: Euler angles are singular, or the tip is nowhere."""


class LeafMemory(NamedTuple):
    """All that one estimator's kernels read and write."""

    numbers: Array
    """Shape (NUMBERS,)."""
    memory: Array
    """Shape (MEMORY,)."""
    seen: Array
    """What the sensors say: P, Ṗ, Φ, Ω, H and Ḣ, shape (12 + 2n,)."""
    acting: Array
    """Place in `vehicle_step`'s given of what acts on the vehicle and of its centre of mass, shape (GIVEN,)."""
    vehicle: Array
    """Memory of the vehicle's observer."""
    door: DoorMemory
    first: DoorMemory
    """The same before anything is known of the leaf."""
    wind: WindMemory
    torque_numbers: Array
    """Of the observer of the hinge's torque,"""
    torque: Array
    """and its memory."""
    quick_numbers: Array
    """Of one that is quick,"""
    quick: Array
    """and its memory."""
    bare: Array
    """Memory of one that knows no wind, with the numbers of the first."""
    contact_numbers: Array
    """Of the contact monitor."""
    contact: Array
    """Its memory."""
    arm: ArmParameters
    tip: Array
    """Scratch, shape (6,)."""
    found: Array
    """Result, shape (FOUND_SIZE,)."""
