"""The whole-body plan in a mission: touch, swing, loss of contact and hold are one problem."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.whole_body_control import WholeBodyController
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.mission.schedule import PlanSchedule, Wanted
from doorman.model import Model
from doorman.planning.hinge import Hinge
from doorman.signals import Command, Measurement

Array = NDArray[np.float64]


class WholeBodyFlight:
    """Plans and commands of a tip at the leaf.

    Args:
        model: Model of the scenario.
        schedule: Plans.
    """

    def __init__(self, model: Model, schedule: PlanSchedule) -> None:
        self._controller = WholeBodyController(model)
        self._schedule, self._hinge = schedule, Hinge.of(model.door)
        self._follows: tuple[float | None] | None = None
        """Where the leaf is to go, while plans are followed."""

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another attitude loop from now on."""
        self._controller.fly_by(loop)

    def carry(self, load: Array) -> None:
        """Go on making a force along leaf and hinge while the tip grips, shape (2,) [N]."""
        self._controller.carry(load)

    def note(self, now: float, command: Command, yaw: float) -> None:
        """Take in what is sent now, in every phase."""
        self._controller.note(now, command, yaw)

    def command(
        self, known: Estimate, measurement: Measurement, follows: bool, time_step: float, goal: float | None = None
    ) -> Command | None:
        """What a plan asks for now; None before the first one is known, and where none is to be followed."""
        if not follows:
            self._follows = None
            return None
        if self._follows != (goal,):
            self._follows = (goal,)
            self._controller.forget(goal)
            self._schedule.forget()
        self._controller.aim(known, measurement.time, time_step)

        def wanted() -> Wanted:
            state, numbers = self._controller.start(known)
            return Wanted(state, self._hinge, numbers, under_way=self._controller.under_way(now))

        now = measurement.time
        current = self._schedule.update(now, wanted)
        if current is None:
            return None
        yaw, yaw_rate = float(measurement.attitude[2]), float(known.attitude_rates[2])
        return self._controller.follow(current.plan, current.start, now, yaw, yaw_rate, time_step)
