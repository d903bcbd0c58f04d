r"""Disturbance observer of the door: the torque in the hinge that the planner does not know of.

Vehicle and leaf move as one along the swing, with the inertia :math:`I_e = I_D + m_A D_V^2` that the push really moves:

.. math:: I_e\ddot\alpha = -D_V F_n - b\dot\alpha - k(\alpha - \alpha_0) - G(\alpha) - \tau_d

with the push F_n. The observer gives :math:`\hat\tau_d = Q(s)\,\tau_d` with a first-order Q, without differentiating the
rate. The planner takes it into α̈. Torques and rate are filtered each by itself: an inertia that is learnt in flight counts
as if it had been known from the start.

Coulomb friction is left to the observer, all of it. In the smooth model τ_c tanh(α̇/ε) a door at rest has none and a moving
one the whole. A plan from rest would pay a second time for the friction that already holds the door, and the opening would
stall degrees short of the goal.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.control.kernels.hinge_step import ESTIMATE, MEMORY, RATE, observe_hinge
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_numbers
from doorman.model import Model


class DoorObserver:
    """Estimate of the unknown hinge torque; right only while the tip is tied to the leaf, or presses on it.

    Args:
        model: Model of the scenario.
        rate: Bandwidth [rad/s]; 0: the estimate stays 0.
        limit: Bound of the estimate [N m].
        whole: Whether the damping and the closer that the scenario names are part of the estimate: a plan that is told of it
            knows nothing else of the hinge.
    """

    def __init__(self, model: Model, rate: float, limit: float, *, whole: bool = False) -> None:
        self.rate = rate
        self.limit = limit
        door, lever = model.door, model.coupling.lever_length
        damping, stiffness = (0.0, 0.0) if whole else (door.damping, door.stiffness)
        self.numbers = np.array(
            [rate, limit, damping, stiffness, lever, model.vehicle.mass * lever**2, door.rest_angle]
        )
        """What the kernel of `hinge_step` reads, shape (NUMBERS,)."""
        self.memory = np.zeros(MEMORY)
        """What it writes to, shape (MEMORY,)."""
        self.memory[RATE] = math.nan
        self._leaf = leaf_numbers(door)

    @property
    def estimate(self) -> float:
        """τ̂_d, in the sense of damping: α̈ gains −τ̂_d/I, so it is negative where it resists opening [N m]."""
        return float(self.memory[ESTIMATE])

    def update(self, door_angle: float, door_rate: float, push: float, inertia: float, time_step: float) -> float:
        """Advance by one period."""
        return observe_hinge(self.numbers, self._leaf, self.memory, door_angle, door_rate, push, inertia, time_step)

    def restart(self, estimate: float) -> None:
        """Go on from another estimate."""
        self.memory[ESTIMATE] = min(max(estimate, -self.limit), self.limit)
        self.pause()

    def pause(self) -> None:
        """Keep the estimate while the tip is away; the next update begins from the rate that it is given."""
        self.memory[RATE] = math.nan
