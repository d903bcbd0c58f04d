"""Memory of `DoorFilter`: places in its state, numbers and memory."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ANGLE, RATE, TORQUE, DAMPING, FRICTION, STIFFNESS, INERTIA, WIND_X, WIND_Y = range(9)
"""Places in the state."""
STATES = 9
(
    LEVER, VEHICLE_INERTIA, REST, PRELOAD, LIGHTEST, HEAVIEST, TORQUE_TIME, ANGLE_NOISE, PUSH_IN_WIND, TORQUE_IN_WIND,
    TYPICAL_WIND, WIND_DEVIATION, WIND_SHARE, WIND_LEVER, CLOSES, END, STOP, NUMBERS,
) = range(18)  # fmt: skip
"""Places in the numbers: constants of the model and of `[estimation]`; `CLOSES` is 1 or −1, the sense in which torques shut,
`END` the lower limit of α, and `STOP` where the leaf shuts no farther."""
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


MOVING = 0.02
"""Slower than this the door counts as standing [rad/s]."""
