"""Memory of one estimator, which its kernels share, and the places in it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.control.kernels.door_filter.memory import DoorMemory
from doorman.kinematics.vehicles.arms.arm import ArmParameters

Array = NDArray[np.float64]

FREE, PUSHING, LEAVING, GRIPPED = range(4)
"""What is known of tip and leaf, as in `Tie`."""
LEVER, MASS, VEHICLE_RATE, WIND_RATE, DOOR_INERTIA, GRIPS, NUMBERS = range(7)
"""Places in the numbers."""
BEYOND, SMOOTHED, DREW_BACK, DOUBTED, FREE_TIME, YAW, IS_TOLD, TOLD, WIND, MEAN_WIND, MEMORY = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    10,
    13,
    16,
)
"""Places in the memory: speed along the normal beyond a gripping tip's, NaN where there is none; smoothed distance of tip and
leaf; whether the tip drew back, and until when a touch is doubted; time in free flight; heading without jumps; whether anything
was commanded, and Φ_d; wind, and its mean."""
(
    AT, MOVES, WIND_NOW, TIP_FORCE, TIP_ANGLE, TIP_SPEED, NORMAL_FORCE, NEAR, TOUCHES, DISTURBANCE, RESPONSE_LAG, PUSH, STATE,
) = 0, 3, 6, 9, 12, 13, 14, 15, 16, 17, 18, 19, 20  # fmt: skip
"""Places in what is found: `Estimate`'s fields."""


class EstimatorMemory(NamedTuple):
    """All that one estimator's kernels read and write."""

    numbers: Array
    """Shape (NUMBERS,)."""
    memory: Array
    """Shape (MEMORY,)."""
    seen: Array
    """What the sensors say: P, Ṗ, Φ, Ω, H and Ḣ, shape (12 + 2n,)."""
    carried: Array
    """Scratch: the same with the vehicle's velocity, and all of it carried on to now, shape (12 + 2n,)."""
    acting: Array
    """Place in `vehicle_step`'s given of what acts on the vehicle and of its centre of mass, shape (GIVEN,)."""
    vehicle: Array
    """Memory of the vehicle's observer."""
    gripped: Array
    """Place in `vehicle_step`'s given of a gripping tip; no force is known to move it, shape (GIVEN,)."""
    grip: Array
    """Memory of that tip's observer."""
    door: DoorMemory
    hinge_numbers: Array
    """Of the hinge's observer."""
    hinge: Array
    """Its memory."""
    contact_numbers: Array
    """Of the contact monitor."""
    contact: Array
    """Its memory."""
    response: Array
    """Memory of the attitude's response."""
    arm: ArmParameters
    tip: Array
    """Scratch, shape (6,)."""
    found: Array
    """Result, shape (STATE + 5 + n,)."""
