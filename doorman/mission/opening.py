"""Opening: following plans until the door stands at the goal, and holding a pushed one there."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.push_control import PushController
from doorman.control.state_converter import StateConverter
from doorman.control.turning_aid import TurningAid
from doorman.mission.holding import Holding
from doorman.mission.progress import NEARLY, Progress
from doorman.mission.resistance import Resistance
from doorman.mission.schedule import PlanSchedule
from doorman.model import GRAVITY, Model
from doorman.planning.quasi_static_planning import push_state

Array = NDArray[np.float64]

_STUCK = 10.0
"""Time without progress after which an opening is given up [s]."""
_STUCK_IN_SWING = 6.0
"""The same for a pushed door that has swung: somebody holds it, and pushing harder tilts the disc onto the leaf [s]."""
SILENT = 0.5
"""A planner that makes one plan for so long is given up; what is flown meanwhile is the last plan, which is longer [s]."""
_AHEAD = math.radians(16.0)
"""No heading is asked for that is farther ahead of a gripped door; where the door gives way, it is 15° at most [rad]."""
_TOO_FAR_AHEAD = math.radians(22.0)
_GIVES_WAY = 0.05
"""A gripping vehicle that is turned farther ahead of a door that is slower leans on it, and is turned on [rad], [rad/s]."""
_HEADING_LOST = math.radians(55.0)
"""A vehicle that is turned so far from the heading that keeps step with the door does not find back [rad]."""


class Opening:
    """Setpoints from the touch until the door is open.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        schedule: Plans.
        push: Controller of a tip that can only push; None if it grips.
    """

    def __init__(
        self, model: Model, converter: StateConverter, schedule: PlanSchedule, push: PushController | None
    ) -> None:
        self._model, self._converter, self._schedule, self._push = model, converter, schedule, push
        self._goal = float(model.goal_state[3])
        self._sense = math.copysign(1.0, float(model.goal_state[2] - model.start_state[2]))
        self._weight = model.vehicle.mass * GRAVITY
        self._turning_aid = TurningAid(model)
        self._progress = Progress(model, push is not None)
        self.resistance = Resistance(model, self._progress, push is not None)
        """What the hinge resists with."""
        self._holding = None if push is None else Holding(model, converter, push, self._progress)
        self._waiting: Setpoint | None = None
        self._last = 0.0

    @property
    def held(self) -> bool:
        """Whether the door is being held, and not moved."""
        return self._holding is not None and self._holding.held

    def may_go_on(self, estimate: Estimate) -> bool:
        """Whether another attempt may do better than one that is stuck: plans come and are flown, and the door has swung."""
        plans = self._schedule.overdue(estimate.time) <= SILENT and not self._schedule.refusal
        return plans and self._progress.swung

    def resume(self, now: float, push: float) -> None:
        """Begin, or go on after contact was regained.

        Args:
            now: [s].
            push: F_n that the tip presses with [N].
        """
        self._schedule.forget()
        self._progress.resume(now)
        self._waiting, self._last = None, now
        if self._holding is not None:
            self._holding.end()
        if self._push is not None:
            self._push.begin(push)

    def hold_again(self, estimate: Estimate, push: float) -> None:
        """Hold a door that was held before, from a push on that has faded meanwhile: it grows to what held the door then.

        One that is gripped is brought back to the goal.

        Args:
            estimate: What is known now.
            push: F_n that the tip presses with [N].
        """
        self.resume(estimate.time, push)
        if self._holding is not None:
            self._holding.begin(estimate)

    def step(self, estimate: Estimate, body_rates: Array) -> Setpoint:
        """Setpoint for now.

        Args:
            estimate: What is known now.
            body_rates: Ω, shape (3,) [rad/s].
        """
        now, held = estimate.time, self.held
        time_step, self._last = now - self._last, now
        self.resistance.learn(estimate, time_step)
        self._progress.update(estimate, held, time_step)
        if self._holding is not None:
            self._holding.update(estimate)
            if self._holding.held:
                return self._holding.step(estimate, time_step)
            if held:
                self._schedule.forget()
        state = self._converter.planner_state(estimate.state, body_rates)
        if self._push is not None:
            state = push_state(self._model, state, self._push.push)
        torque = self.resistance.torque(estimate, time_step)
        current = self._schedule.update(now, state, self.resistance.hinge(estimate, torque), self._lean(estimate))
        if current is None:
            if self._waiting is None:
                self._waiting = self._converter.hold(estimate.position, float(estimate.state[2]))
            setpoint = self._waiting
            return setpoint if self._push is None else self._push.hold(setpoint, self._push.push, estimate)
        self._waiting = None
        if self._push is None:
            setpoint = self._converter.setpoint(current.plan, now - current.start, estimate.arm_angles)
            turning = self._converter.turning(current.plan, now - current.start)
            beyond = self._ahead(setpoint.yaw, estimate.door_angle) - _AHEAD
            if beyond > 0.0:  # plans turn with a door that should move, and one that is held does not
                setpoint, turning = replace(setpoint, yaw=setpoint.yaw - self._sense * beyond), 0.0
            aid = self._turning_aid.force(estimate.state, body_rates, turning, time_step, estimate.attitude_lag)
            return replace(setpoint, force=setpoint.force + aid)
        return self._push.follow(current.plan, now - current.start, estimate, -torque, time_step)

    def _lean(self, estimate: Estimate) -> float:
        """How much nearer to the leaf a vehicle comes that leans into the wind about its tip [m]."""
        if self._push is None:
            return 0.0
        depth = abs(float(self._model.vehicle.tip_position(estimate.arm_angles)[2]))
        return depth * float(np.hypot(estimate.wind[0], estimate.wind[1])) / self._weight

    def done(self, now: float) -> bool:
        """Whether the door has stood at the goal for long enough, and stands still right now.

        Args:
            now: [s].
        """
        return self._progress.done(now)

    def stuck(self, estimate: Estimate) -> str:
        """Why the opening should be given up; empty if it should not."""
        if (late := self._schedule.overdue(estimate.time)) > SILENT:
            return f"the planner is silent for {late:.1f} s"
        angle = math.degrees(estimate.door_angle)
        ahead = self._ahead(float(estimate.state[2]), estimate.door_angle)
        if self._push is None and ahead > _TOO_FAR_AHEAD and abs(self._progress.rate) < _GIVES_WAY:
            return f"the door does not give way: {math.degrees(ahead):.0f}° ahead of it at {angle:.1f}°"
        if abs(ahead) > _HEADING_LOST:
            turned = math.degrees(abs(ahead))
            return f"the heading is lost: {turned:.0f}° beside where it should be at {angle:.1f}°"
        in_swing = self.resistance.known and estimate.door_angle - self._goal > NEARLY  # nearer, it has come back
        if self._progress.stuck_for(estimate.time) < (_STUCK_IN_SWING if in_swing else _STUCK):
            return ""
        return f"the door does not move on from {angle:.1f}° against {max(0.0, -estimate.door_disturbance):.2f} N m" + (
            f"; the last plan: {self._schedule.refusal}" if self._schedule.refusal else ""
        )

    def _ahead(self, yaw: float, door_angle: float) -> float:
        """By how much a heading is ahead of the one that keeps step with the door [rad]."""
        return self._sense * math.remainder(yaw - float(self._model.on_the_way(door_angle)[2]), 2.0 * math.pi)
