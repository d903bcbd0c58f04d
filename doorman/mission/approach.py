"""To a hover before the door, and from there to where the touch begins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.at_the_leaf import AtTheLeaf
from doorman.mission.motion import Glide, arm_rates_to
from doorman.mission.since import since
from doorman.model import Model

Array = NDArray[np.float64]

_STEADY = 1.0
"""For which the vehicle must hover still before the approach, and must be held up to have met something [s]."""
_HELD_UP = 0.03
"""A slower vehicle stands [m/s]."""


class Approach:
    """Of one attempt.

    Args:
        model: Model of the scenario.
        leaf: Where the contact point is.
        glide: What the vehicle follows already; None where it begins.
    """

    def __init__(self, model: Model, leaf: AtTheLeaf, glide: Glide | None = None) -> None:
        self._model, self._leaf, self._glide = model, leaf, glide
        self._settings = model.scenario.mission
        self._still_since: float | None = None
        self._held_up_since: float | None = None

    def to_hover(self, estimate: Estimate, time_step: float) -> tuple[Setpoint, bool]:
        """Go on to the hover before the door, once per tick.

        Args:
            estimate: What is known now.
            time_step: Since the last call [s].

        Returns:
            What to do, and whether the vehicle hovers there, still, in the start's posture.
        """
        setpoint, target, _ = self._fly(estimate, self._model.hover_offset, time_step)
        still = np.linalg.norm(estimate.position - target) < 0.06 and np.linalg.norm(estimate.velocity) < 0.08
        posed = np.abs(estimate.arm_angles - self._model.start_arm).max(initial=0.0) < 0.03
        self._still_since = since(self._still_since, bool(still and posed), estimate.time)
        return setpoint, self._still_since is not None and estimate.time - self._still_since >= _STEADY

    def to_leaf(self, estimate: Estimate, time_step: float) -> tuple[Setpoint, bool, str]:
        """Go on to where the touch begins, once per tick.

        Args:
            estimate: What is known now.
            time_step: Since the last call [s].

        Returns:
            What to do, whether the touch begins, and why it begins if the vehicle is not there.
        """
        before = -self._settings.touch_distance * self._model.door.normal(estimate.door_angle)
        setpoint, target, glide = self._fly(estimate, before, time_step)
        waits = glide.near(target, 0.01)
        if waits and np.linalg.norm(estimate.position - target) < 0.05:
            return setpoint, True, ""
        held_up = waits and np.linalg.norm(estimate.velocity) < _HELD_UP
        self._held_up_since = since(self._held_up_since, bool(held_up), estimate.time)
        met = self._held_up_since is not None and estimate.time - self._held_up_since >= _STEADY
        return setpoint, met, "something is before the leaf's place" if met else ""

    def _fly(self, estimate: Estimate, away: Array, time_step: float) -> tuple[Setpoint, Array, Glide]:
        """Setpoint on the way to a place away from where the tip touches, that place, and what is followed."""
        self._glide = self._glide or Glide(estimate.position, float(estimate.state[2]))
        yaw, arm = float(self._model.start_state[2]), self._model.start_arm
        target = self._leaf.contact_position(estimate, yaw, arm) + away
        rates = arm_rates_to(arm, estimate.arm_angles)
        return self._glide.to(target, yaw, self._settings.approach_speed, rates, time_step), target, self._glide
