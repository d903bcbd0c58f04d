"""What every opening has, gripped or pushed: plans that are followed, progress, and when it is over."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.mission.opening.progress import Progress
from doorman.mission.schedule import PlanSchedule
from doorman.model import Model

Array = NDArray[np.float64]

SILENT = 0.5
"""A planner that makes one plan for so long is given up; what is flown meanwhile is the last plan, which is longer [s]."""
HEADING_LOST = math.radians(55.0)
"""A vehicle that is turned so far from the heading that keeps step with the door does not find back [rad]."""


class DoorOpening(ABC):
    """Opening of one attempt, from the touch until the door is open.

    Args:
        model: Model of the scenario.
        schedule: Plans.
        pushes: Whether the tip can only push.
    """

    def __init__(self, model: Model, schedule: PlanSchedule, pushes: bool) -> None:
        self._model, self._schedule = model, schedule
        self._progress = Progress(model, pushes)
        self.held = False
        """Whether the door is being held, and not moved: never with a grip, which moves a door to where it stays."""

    def may_go_on(self, estimate: Estimate) -> bool:
        """Whether another attempt may do better than one that is stuck: plans come and are flown, and the door has swung."""
        plans = self._schedule.overdue(estimate.time) <= SILENT and not self._schedule.refusal
        return plans and self._progress.swung

    def done(self, now: float) -> bool:
        """Whether the door has stood at the goal for long enough, and stands still right now."""
        return self._progress.done(now)

    @abstractmethod
    def resume(self, now: float, push: float) -> None:
        """Begin, or go on after contact was regained."""

    @abstractmethod
    def hold_again(self, estimate: Estimate, push: float) -> None:
        """Hold a door that was held before, or bring it back to the goal."""

    @abstractmethod
    def step(self, estimate: Estimate, body_rates: Array) -> Setpoint:
        """Take in where the door is, once per tick."""

    @abstractmethod
    def keeps_the_door(self, estimate: Estimate) -> bool:
        """Whether the door may stay by itself."""

    @abstractmethod
    def stuck(self, estimate: Estimate) -> str:
        """Reason to give the opening up; empty if there is none."""

    def _silence(self, now: float) -> str:
        """That the planner is silent; empty if it is not."""
        late = self._schedule.overdue(now)
        return f"the planner is silent for {late:.1f} s" if late > SILENT else ""

    def _does_not_move(self, estimate: Estimate, resists: float) -> str:
        """That the door stands, and against what torque [N m]."""
        door, refusal = self._model.door, self._schedule.refusal
        stands = f"the door does not move on from {door.in_words(estimate.door_angle)} against {door.torque_in_words(resists)}"
        return stands + (f"; the last plan: {refusal}" if refusal else "")
