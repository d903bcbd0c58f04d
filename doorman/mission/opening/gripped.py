"""Opening of a gripped door: following plans until it stands at the goal."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.state_converter import StateConverter
from doorman.control.turning_aid import TurningAid
from doorman.mission.opening.door_opening import HEADING_LOST, DoorOpening
from doorman.mission.opening.resistance import Resistance
from doorman.mission.schedule import PlanSchedule, Wanted
from doorman.model import Model

Array = NDArray[np.float64]

_STUCK = 10.0
"""Time without progress after which an opening is given up [s]."""
_AHEAD = math.radians(16.0)
"""No heading is asked for that is farther ahead of a gripped door; where the door gives way, it is 15° at most [rad]."""
_TOO_FAR_AHEAD = math.radians(22.0)
_GIVES_WAY = 0.05
"""A gripping vehicle that is turned farther ahead of a door that is slower leans on it, and is turned on [rad], [rad/s]."""


class Opening(DoorOpening):
    """Setpoints from the touch until the door is open.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        schedule: Plans.
    """

    def __init__(self, model: Model, converter: StateConverter, schedule: PlanSchedule) -> None:
        super().__init__(model, schedule, pushes=False)
        self._converter = converter
        self._sense = math.copysign(1.0, float(model.goal_state[2] - model.start_state[2]))
        self._turning_aid = TurningAid(model)
        self.resistance = Resistance(model, self._progress)
        """What the hinge resists with."""
        self._waiting: Setpoint | None = None

    def resume(self, now: float, push: float) -> None:
        """Begin.

        Args:
            now: [s].
            push: F_n that the tip presses with [N].
        """
        self._schedule.forget()
        self._progress.resume(now)
        self._waiting, self._last = None, now

    def hold_again(self, estimate: Estimate, push: float) -> None:
        """Bring a door that was held before back to the goal.

        Args:
            estimate: What is known now.
            push: F_n that the tip presses with [N].
        """
        self.resume(estimate.time, push)

    def keeps_the_door(self, estimate: Estimate) -> bool:
        """Whether the door may stay by itself.

        Args:
            estimate: What is known now.
        """
        return self.resistance.keeps_the_door(estimate)

    def step(self, estimate: Estimate, body_rates: Array) -> Setpoint:
        """Setpoint for now.

        Args:
            estimate: What is known now.
            body_rates: Ω, shape (3,) [rad/s].
        """
        now, time_step = estimate.time, estimate.time - self._last
        self._last = now
        self.resistance.learn(estimate, time_step)
        self._progress.update(estimate, False, time_step)
        torque = self.resistance.torque(estimate, time_step) + self._torque_of_wind(estimate)

        def wanted() -> Wanted:
            state = self._converter.planner_state(estimate.state, body_rates)
            return Wanted(state, self.resistance.hinge(estimate, torque))

        current = self._schedule.update(now, wanted)
        if current is None:
            if self._waiting is None:
                self._waiting = self._converter.hold(estimate.position, estimate.yaw)
            return self._waiting
        self._waiting = None
        setpoint = self._converter.setpoint(current.plan, now - current.start, estimate.arm_angles)
        turning = self._converter.turning(current.plan, now - current.start)
        beyond = self._ahead(setpoint.yaw, estimate.door_angle) - _AHEAD
        if beyond > 0.0:  # plans turn with a door that should move, and one that is held does not
            setpoint, turning = replace(setpoint, yaw=setpoint.yaw - self._sense * beyond), 0.0
        aid = self._turning_aid.force(estimate.state, body_rates, turning, time_step, estimate.attitude_lag)
        return replace(setpoint, force=setpoint.force + aid)

    def stuck(self, estimate: Estimate) -> str:
        """Reason to give the opening up; empty if there is none. See `DoorOpening`.

        Args:
            estimate: What is known now.
        """
        if silence := self._silence(estimate.time):
            return silence
        angle = self._model.door.in_words(estimate.door_angle)
        ahead = self._ahead(estimate.yaw, estimate.door_angle)
        if ahead > _TOO_FAR_AHEAD and abs(self._progress.rate) < _GIVES_WAY:
            return f"the door does not give way: the vehicle is {math.degrees(ahead):.0f}° ahead of it at {angle}"
        if abs(ahead) > HEADING_LOST:
            turned = math.degrees(abs(ahead))
            return f"the heading is lost: {turned:.0f}° off at {angle}"
        if self._progress.stuck_for(estimate.time) < _STUCK:
            return ""
        resists = max(0.0, self._model.travel.ahead(estimate.door_disturbance))
        return self._does_not_move(estimate, resists)

    def _torque_of_wind(self, estimate: Estimate) -> float:
        """Of the wind on the vehicle in the hinge, in the sense of damping: rotors that push against it do not push the leaf.

        Plans know nothing else of it, and the controller leaves what acts along the normal to them.
        """
        wind = float(self._model.door.normal(estimate.door_angle) @ estimate.wind)
        return self._model.coupling.lever_length * wind

    def _ahead(self, yaw: float, door_angle: float) -> float:
        """By how much a heading is ahead of the one that keeps step with the door [rad]."""
        return self._sense * math.remainder(yaw - float(self._model.on_the_way(door_angle)[2]), 2.0 * math.pi)
