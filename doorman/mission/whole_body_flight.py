"""The whole-body plan in a mission: touch, swing, loss of contact and hold are one problem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.estimation.leaf_estimator import LeafEstimate, LeafEstimator
from doorman.control.held_leaf import HeldLeaf
from doorman.control.state_converter import StateConverter
from doorman.control.whole_body_control import WholeBodyController
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.mission.schedule import PlanSchedule, Wanted
from doorman.model import Model
from doorman.planning.hinge import Hinge
from doorman.signals import Command, Measurement

Array = NDArray[np.float64]


class WholeBodyFlight:
    """Estimates, plans and commands of a tip at the leaf.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        schedule: Plans.
    """

    def __init__(self, model: Model, converter: StateConverter, schedule: PlanSchedule) -> None:
        self._controller, self._held = WholeBodyController(model), HeldLeaf(model, converter)
        self._estimator = LeafEstimator(model, converter) if model.scenario.contact.kind == "push" else None
        self._model, self._schedule, self._hinge = model, schedule, Hinge.of(model.door)
        self._known: LeafEstimate | None = None
        self._follows: tuple[bool, float | None] | None = None
        """Whether the tip grips, and where the leaf is to go, while plans are followed."""

    def listen(
        self, measurement: Measurement, force: Array, estimate: Estimate, seeks: bool, time_step: float
    ) -> Estimate:
        """Take in one measurement, in every phase."""
        if self._estimator is None:
            self._known = None
            if estimate.touching:
                self._known = self._held.update(estimate, measurement, force, time_step)
            else:
                self._held.let_go()
            return estimate
        wanted = self._controller.opening_rate
        self._known = known = self._estimator.update(measurement, force, time_step, seeks, wanted)
        if not seeks:
            return replace(estimate, wind=known.wind, hinge=known.hinge)
        state = estimate.state.copy()
        state[3:5] = known.door_angle, known.door_rate
        turned = self._model.coupling.angle_of_face(known.face_offset)
        return replace(
            estimate, state=state, wind=known.wind, touching=known.touching, normal_force=known.normal_pull,
            tip_force=estimate.tip_force + known.wind - estimate.wind, tip_angle=estimate.tip_angle - turned,
            push=known.normal_force, hinge=known.hinge,
        )  # fmt: skip

    def know_the_face(self) -> None:
        """From now on the door stands where it is believed: a leaf that is met elsewhere stands ajar."""
        if self._estimator is not None:
            self._estimator.know_the_face()

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another attitude loop from now on."""
        self._controller.fly_by(loop)

    def note(self, now: float, command: Command, yaw: float) -> None:
        """Take in what is sent now, in every phase."""
        self._controller.note(now, command, yaw)

    def command(
        self,
        measurement: Measurement,
        at_the_leaf: bool,
        time_step: float,
        grips: bool = False,
        goal: float | None = None,
    ) -> Command | None:
        """What the vehicle is to do now."""
        known = self._known
        if not at_the_leaf or known is None:
            self._follows = None
            return None
        if self._follows != (grips, goal):
            self._follows = grips, goal
            self._controller.forget(grips, goal)
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
