"""The paper's plan in a mission: setpoints of a vehicle whose gripper holds the leaf."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.state_converter import StateConverter
from doorman.mission.schedule import PlanSchedule, Wanted
from doorman.model import Model
from doorman.planning.hinge import Hinge

Array = NDArray[np.float64]


class QuasiStaticFlight:
    """Follows quasi-static and Lagrangian plans by position, heading and force.

    Args:
        model: Model of the scenario.
        converter: Its state converter.
        schedule: Plans.
    """

    def __init__(self, model: Model, converter: StateConverter, schedule: PlanSchedule) -> None:
        self._model, self._converter, self._schedule = model, converter, schedule
        self._observed = model.scenario.control.door_observer_rate > 0.0
        self._follows: tuple[float | None] | None = None
        self._waits = converter.hold(np.zeros(3), 0.0)

    def setpoint(
        self, estimate: Estimate, body_rates: Array, holds: bool, goal: float | None = None
    ) -> Setpoint | None:
        """What a plan asks for now; the vehicle waits where it is for the first one. None while the gripper does not hold."""
        if not holds:
            self._follows = None
            return None
        if self._follows != (goal,):
            self._follows, self._waits = (goal,), self._converter.hold(estimate.position, estimate.yaw)
            self._schedule.forget()

        def wanted() -> Wanted:
            return Wanted(self._converter.planner_state(estimate.state, body_rates), self._hinge(estimate), goal=goal)

        current = self._schedule.update(estimate.time, wanted)
        if current is None:
            return self._waits
        return self._converter.setpoint(current.plan, estimate.time - current.start, estimate.arm_angles)

    def _hinge(self, estimate: Estimate) -> Hinge:
        """What plans know: the hinge as it is estimated, and a disturbance that makes the sum of its torques what it is now.

        The wind on the vehicle belongs to it: rotors that push against it do not push the leaf.
        """
        hinge, door, model = estimate.hinge, self._model.door, self._model
        wind = float(door.normal(estimate.door_angle) @ estimate.wind)
        torque = estimate.door_disturbance + model.coupling.lever_length * wind
        if not self._observed:
            return Hinge.of(door, torque)
        torque += (door.damping - hinge.damping) * estimate.door_rate
        torque += (door.stiffness - hinge.stiffness) * (estimate.door_angle - door.rest_angle)
        return Hinge(0.0, torque, hinge.inertia, hinge.damping, hinge.stiffness)
