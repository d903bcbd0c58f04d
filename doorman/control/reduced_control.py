"""From what is known at the leaf to the start of a quasi-static or Lagrangian plan, and from the plan to setpoints."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.position_controller import Setpoint
from doorman.control.state_converter import StateConverter
from doorman.control.wanted import Wanted
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.kinematics.rotations import body_rates_of
from doorman.planning.hinge import Hinge
from doorman.planning.plan import Plan
from doorman.planning.planning_model import planning_model
from doorman.signals import Command


class ReducedController:
    """Starts of plans of a tip that is tied to the leaf, and setpoints of position, heading and force."""

    def __init__(self, converter: StateConverter) -> None:
        self._converter, self._model = converter, converter.model
        self._planning = planning_model(converter.model)
        self._observed = self._model.scenario.control.door_observer_rate > 0.0
        self._goal: float | None = None
        self._arm: Array = np.zeros(self._model.n_arm)
        self.waits: Setpoint | None = None
        """Where the vehicle waits for the first plan."""

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another attitude loop from now on: the state converter does."""

    def carry(self, load: Array) -> None:
        """No load is known to these plans."""

    def note(self, now: float, command: Command, measured_yaw: float) -> None:
        """Nothing is under way in these plans."""

    def forget(self, goal: float | None = None) -> None:
        """Begin anew, to bring the leaf to the goal, or to another angle [rad]."""
        self._goal, self.waits = goal, None

    def aim(self, known: Estimate, now: float, time_step: float) -> None:
        """Take in what is known now."""
        self._arm = known.arm_angles
        self.waits = self.waits or self._converter.hold(known.position, known.yaw)

    def wanted(self, known: Estimate, now: float) -> Wanted:
        """A plan from now on."""
        body_rates = body_rates_of(known.attitude[None], known.attitude_rates[None])[0]
        return Wanted(self._planning.state(known.state, body_rates), self._hinge(known), goal=self._goal)

    def follow(
        self, plan: Plan, start: float, now: float, measured_yaw: float, yaw_rate: float, time_step: float
    ) -> Setpoint:
        """Where the vehicle is to be in a plan that started some time ago."""
        return self._converter.setpoint(plan, now - start, self._arm)

    def _hinge(self, known: Estimate) -> Hinge:
        """What plans know: the hinge as it is estimated, and a disturbance that makes the sum of its torques what it is now.

        The wind on the vehicle belongs to it: rotors that push against it do not push the leaf.
        """
        hinge, door, model = known.hinge, self._model.door, self._model
        wind = float(known.normal @ known.wind)
        torque = known.door_disturbance + model.coupling.lever_length * wind
        if not self._observed:
            return Hinge.of(door, torque)
        torque += (door.damping - hinge.damping) * known.door_rate
        torque += (door.stiffness - hinge.stiffness) * (known.door_angle - door.rest_angle)
        return Hinge(0.0, torque, hinge.inertia, hinge.damping, hinge.stiffness)
