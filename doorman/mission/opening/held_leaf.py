"""Motion of a vehicle whose gripper holds the leaf: plans that bring the door to an angle, and are followed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.state_converter import StateConverter
from doorman.control.turning_aid import TurningAid
from doorman.mission.schedule import PlanSchedule, Wanted
from doorman.model import Model
from doorman.planning.grip.pushes import LargestPushes
from doorman.planning.hinge import Hinge

Array = NDArray[np.float64]

_SHARE = 0.98
"""Of the torque that the vehicle makes, the most that plans are told of; a door that takes more stands still."""
_AHEAD = math.radians(16.0)
"""No heading is asked for that is farther ahead of a gripped door; where the door gives way, it is 15° at most [rad]."""


class HeldLeaf:
    """The leaf in the gripper: a whole-body plan is followed by its inputs, and the vehicle waits where it is for the first.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
    """

    def __init__(self, model: Model, converter: StateConverter) -> None:
        self._model, self._converter = model, converter
        self._sense = math.copysign(1.0, float(model.goal_state[2] - model.start_state[2]))
        self._waiting: Setpoint | None = None

    def begin(self, now: float) -> None:
        """Begin."""
        self._waiting = None

    def follow(
        self, estimate: Estimate, body_rates: Array, torque: Callable[[], float], goal: float | None = None
    ) -> Setpoint:
        """Setpoint for now; once per tick."""
        if self._waiting is None:
            self._waiting = self._converter.hold(estimate.position, estimate.yaw)
        return self._waiting

    def ahead(self, yaw: float, door_angle: float) -> float:
        """By how much a heading is ahead of the one that keeps step with the door, on the way to the scenario's goal [rad]."""
        return self._sense * math.remainder(yaw - float(self._model.on_the_way(door_angle)[2]), 2.0 * math.pi)


class QuasiStaticHold(HeldLeaf):
    """Setpoints that follow a quasi-static or Lagrangian plan, which knows the vehicle's own motion but not its lag.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        schedule: Plans.
    """

    def __init__(self, model: Model, converter: StateConverter, schedule: PlanSchedule) -> None:
        super().__init__(model, converter)
        self._schedule = schedule
        self._observed = model.scenario.control.door_observer_rate > 0.0
        self._turning_aid, self._pushes = TurningAid(model), LargestPushes(model)
        self._last = 0.0

    def begin(self, now: float) -> None:
        """Begin: plans that were made before are not followed any more."""
        super().begin(now)
        self._schedule.forget()
        self._last = now

    def follow(
        self, estimate: Estimate, body_rates: Array, torque: Callable[[], float], goal: float | None = None
    ) -> Setpoint:
        """Setpoint for now; once per tick."""
        now, time_step = estimate.time, estimate.time - self._last
        self._last = now
        resists = torque() + self._torque_of_wind(estimate)

        def wanted() -> Wanted:
            state = self._converter.planner_state(estimate.state, body_rates)
            return Wanted(state, self._hinge(estimate, resists), goal=goal)

        current = self._schedule.update(now, wanted)
        if current is None:
            return super().follow(estimate, body_rates, torque, goal)
        setpoint = self._converter.setpoint(current.plan, now - current.start, estimate.arm_angles)
        turning = self._converter.turning(current.plan, now - current.start)
        way = 1.0 if goal is None else -1.0
        beyond = way * self.ahead(setpoint.yaw, estimate.door_angle) - _AHEAD
        if beyond > 0.0:  # plans turn with a door that should move, and one that is held does not
            setpoint, turning = replace(setpoint, yaw=setpoint.yaw - way * self._sense * beyond), 0.0
        aid = self._turning_aid.force(estimate.state, body_rates, turning, time_step, self._converter.loop.lag)
        return replace(setpoint, force=setpoint.force + aid)

    def _hinge(self, estimate: Estimate, torque: float) -> Hinge:
        """What plans are told: the estimated parameters, and a disturbance that makes their sum what it is now.

        Without an observer that finds that sum, it is the scenario's hinge.
        """
        hinge, door = estimate.hinge, self._model.door
        if not self._observed:
            return Hinge.of(door, torque)
        torque += (door.damping - hinge.damping) * estimate.door_rate
        torque += (door.stiffness - hinge.stiffness) * (estimate.door_angle - door.rest_angle)
        return self._within_reach(
            Hinge(0.0, torque, hinge.inertia, hinge.damping, hinge.stiffness), estimate.door_angle
        )

    def _within_reach(self, hinge: Hinge, angle: float) -> Hinge:
        """A hinge that the vehicle can move, here and on the way to the goal: its estimate is as noisy as the poses."""
        model, rest = self._model, self._model.door.rest_angle
        lever, weight = _SHARE * model.coupling.lever_length, model.door.weight_torque(angle)
        most, total = lever * self._pushes.at(angle), hinge.torque_at_rest(angle, rest) + weight
        total, left = min(max(total, -most), most), abs(model.goal_angle - angle)
        room = lever * self._pushes.at(model.goal_angle) - model.travel.ahead(total)
        stiffness = min(hinge.stiffness, max(room, 0.0) / left) if left > 0.0 else hinge.stiffness
        return hinge._replace(stiffness=stiffness, disturbance=total - weight - stiffness * (angle - rest))

    def _torque_of_wind(self, estimate: Estimate) -> float:
        """Of the wind on the vehicle in the hinge, in the sense of damping: rotors that push against it do not push the leaf.

        Plans know nothing else of it, and the controller leaves what acts along the normal to them.
        """
        wind = float(self._model.door.normal(estimate.door_angle) @ estimate.wind)
        return self._model.coupling.lever_length * wind
