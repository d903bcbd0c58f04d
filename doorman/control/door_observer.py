r"""Disturbance observer of the door: the torque in the hinge that the planner does not know of.

Vehicle and leaf move as one along the swing, with the inertia :math:`I_e = I_D + m_A D_V^2` that the push really moves:

.. math:: I_e\ddot\alpha = -D_V\, n_D^T F - b\dot\alpha - k(\alpha - \alpha_0) - \tau_d

with the rotors' force F. The observer of the momentum :math:`I_e\dot\alpha` gives :math:`\hat\tau_d = Q(s)\,\tau_d` with a
first-order Q, without differentiating the rate. The planner takes it into α̈.

Coulomb friction is left to the observer, all of it: in the smooth model τ_c tanh(α̇/ε) a door at rest has none and a moving
one the whole, so that a plan from rest would pay for the friction that already holds the door a second time, and the
opening stalls degrees short of the goal.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from doorman.model import Model

Array = NDArray[np.float64]


class DoorObserver:
    """Estimate of the unknown hinge torque; right only while the tip is tied to the leaf, or presses on it.

    Args:
        model: Model of the scenario.
        rate: Bandwidth [rad/s]; 0: the estimate stays 0.
        limit: Bound of the estimate [N m].
    """

    def __init__(self, model: Model, rate: float, limit: float) -> None:
        self.rate = rate
        self.limit = limit
        self._door = model.door
        self._lever = model.coupling.distance_from_hinge
        self._inertia = model.door.inertia + model.vehicle.mass * self._lever**2
        self._momentum: float | None = None
        self.estimate = 0.0
        """τ̂_d, in the sense of damping: α̈ gains −τ̂_d/I, so it is negative where it resists opening [N m]."""

    def update(self, door_angle: float, door_rate: float, force: Array, time_step: float) -> float:
        """Advance by one period.

        Args:
            door_angle: α [rad].
            door_rate: α̇ [rad/s].
            force: Force of the rotors since the last call, shape (3,), world frame [N].
            time_step: Since the last call [s].

        Returns:
            τ̂_d [N m].
        """
        if self.rate == 0.0:
            return self.estimate
        momentum = self._inertia * door_rate
        if self._momentum is None:
            self._momentum = momentum + self.estimate / self.rate
        push = math.sin(door_angle) * force[0] - math.cos(door_angle) * force[1]
        door = self._door
        resistance = door.damping * door_rate + door.stiffness * (door_angle - door.rest_angle)
        known = -self._lever * push - resistance
        self._momentum += time_step * (known - self.estimate)
        raw = self.rate * (self._momentum - momentum)
        self.estimate = min(max(raw, -self.limit), self.limit)
        self._momentum = momentum + self.estimate / self.rate  # anti-windup: the state stays where the bound is
        return self.estimate

    def pause(self) -> None:
        """Keep the estimate while the tip is away; the next update begins from the rate that it is given."""
        self._momentum = None
