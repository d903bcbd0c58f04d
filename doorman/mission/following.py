"""Plans in a mission: when they are made anew, and what follows from one that is known."""

from __future__ import annotations

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.reduced_control import ReducedController
from doorman.control.state_converter import StateConverter
from doorman.control.whole_body_control import WholeBodyController
from doorman.mission.schedule import PlanSchedule
from doorman.signals import Command, Measurement


class Following:
    """Follows plans while a phase asks for it, to the angle that it asks for."""

    def __init__(self, converter: StateConverter, schedule: PlanSchedule) -> None:
        whole = converter.model.scenario.planner.model == "whole_body"
        self.controller = WholeBodyController(converter.model) if whole else ReducedController(converter)
        """Knows where plans begin, and what they command."""
        self._schedule = schedule
        self._goal: tuple[float | None] | None = None
        """Where the leaf is to go, while plans are followed."""

    def follow(
        self, known: Estimate, measured: Measurement, follows: bool, goal: float | None, time_step: float
    ) -> Setpoint | Command | None:
        """What a plan asks for now; None where none is to be followed, or known yet."""
        controller, now = self.controller, measured.time
        if not follows:
            self._goal = None
            return None
        if self._goal != (goal,):
            self._goal = (goal,)
            self._schedule.forget()
            controller.forget(goal)
        controller.aim(known, now, time_step)
        current = self._schedule.update(now, lambda: controller.wanted(known, now))
        if current is None:
            return controller.waits
        yaw, yaw_rate = float(measured.attitude[2]), float(known.attitude_rates[2])
        return controller.follow(current.plan, current.start, now, yaw, yaw_rate, time_step)
