"""The end: hover where the vehicle is, or keep the tip on the leaf."""

from __future__ import annotations

import math

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate, Tie
from doorman.control.position_controller import Setpoint
from doorman.mission.phases.attempt import Attempt
from doorman.mission.phases.free_flight.retreat import Retreat
from doorman.mission.phases.phase import MissionPhase, Phase, Then
from doorman.planning.pace import OPEN


class Done(Retreat):
    """Goes no farther than the vehicle is."""

    phase, leaves, tie, longest = Phase.DONE, False, Tie.FREE, math.inf

    def __init__(self, attempt: Attempt, estimate: Estimate, before: MissionPhase | None) -> None:
        super().__init__(attempt, estimate, before)
        self._targets = [estimate.position]
        if isinstance(before, Retreat):
            self.glide = before.glide
        if attempt.opened and abs(estimate.door_angle - attempt.model.goal_angle) > OPEN:
            attempt.opened = False
            stands = attempt.model.door.in_words(estimate.door_angle, 0)
            attempt.seen = f"by its own estimate the door is at {stands}"

    @property
    def closes_gripper(self) -> bool:
        """Whether the tip is to stay on the leaf."""
        return self.attempt.keeps_hold

    def speed_back(self, estimate: Estimate) -> float:
        """Zero: the vehicle hovers."""
        return 0.0

    def step(self, estimate: Estimate, body_rates: Array, time_step: float) -> tuple[Setpoint, Then]:
        """Hover on."""
        return self._fly(estimate, time_step)[0], None
