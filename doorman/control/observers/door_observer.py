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
        self._door = model.door
        self._damping, self._stiffness = (0.0, 0.0) if whole else (model.door.damping, model.door.stiffness)
        self._lever = model.coupling.lever_length
        self._vehicle_inertia = model.vehicle.mass * self._lever**2
        self._torque = 0.0
        self._rate: float | None = None
        self.estimate = 0.0
        """τ̂_d, in the sense of damping: α̈ gains −τ̂_d/I, so it is negative where it resists opening [N m]."""

    def update(self, door_angle: float, door_rate: float, push: float, inertia: float, time_step: float) -> float:
        """Advance by one period.

        Args:
            door_angle: α [rad].
            door_rate: α̇ [rad/s].
            push: F_n since the last call [N].
            inertia: I_D [kg m²].
            time_step: Since the last call [s].

        Returns:
            τ̂_d [N m].
        """
        if self.rate == 0.0:
            return self.estimate
        door, whole = self._door, inertia + self._vehicle_inertia
        if self._rate is None:
            self._rate, self._torque = door_rate, self.estimate
        resistance = self._damping * door_rate + self._stiffness * (door_angle - door.rest_angle)
        resistance += door.weight_torque(door_angle)
        part = 1.0 - math.exp(-self.rate * time_step)
        self._torque += part * (-self._lever * push - resistance - self._torque)
        self._rate += part * (door_rate - self._rate)
        taken = whole * self.rate * (door_rate - self._rate)
        self.estimate = min(max(self._torque - taken, -self.limit), self.limit)
        self._torque = self.estimate + taken  # anti-windup: the state stays where the bound is
        return self.estimate

    def restart(self, estimate: float) -> None:
        """Go on from another estimate.

        Args:
            estimate: τ̂_d [N m].
        """
        self.estimate = min(max(estimate, -self.limit), self.limit)
        self.pause()

    def pause(self) -> None:
        """Keep the estimate while the tip is away; the next update begins from the rate that it is given."""
        self._rate = None
