"""State converter: plans, whatever their model, to setpoints of the position controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from doorman.arrays import Array
from doorman.control.position_controller import Setpoint
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.kinematics.coupling import VehicleMotion
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.planning.plan import Plan
from doorman.planning.planning_model import planning_model


@dataclass(frozen=True)
class LookAheads:
    """By how much later than the measured state a plan's parts are taken, as the loops that follow them lag behind [s]."""

    acceleration: float
    """Look-ahead of the acceleration fed forward [s]."""
    attitude: float
    """Look-ahead of yaw and of the force fed forward, which act through the attitude loop [s]."""
    position: float = 0.04
    """Look-ahead of position and velocity [s]: two steps of a plan, the position loop's lag."""
    arm: float = 0.1
    """Look-ahead of the arm's posture [s]: joint rates reach it within a servo's lag."""

    @classmethod
    def of(cls, loop: AttitudeLoop) -> LookAheads:
        """Those that follow from lag and dead time of the vehicle's loop."""
        return cls(loop.acceleration_look_ahead, loop.look_ahead)


class StateConverter:
    """From the planner to the vehicle, by the kinematic constraint."""

    def __init__(self, model: Model, ahead: LookAheads | None = None) -> None:
        self.model = model
        self._ahead = ahead or LookAheads.of(model.attitude_loop)
        self._planning = planning_model(model)
        self._coupling = model.coupling
        self._rate_limits = np.asarray(model.vehicle.rate_limits)
        # compiles: nothing is in flight
        self._coupling.vehicle_motion(model.start_state, np.zeros(3), np.zeros(model.n_arm))

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another attitude loop from now on."""
        self._ahead = LookAheads.of(loop)

    def setpoint(self, plan: Plan, time: float, arm_angles: Array) -> Setpoint:
        """Setpoint for a time of the plan; after its end, the last state at rest.

        Each part is taken from the plan as much later as the loop that follows it lags behind (`LookAheads`).
        Joint rates lead from the measured posture to the plan's, so that a correction which the plan makes in its first
        step is not lost between two plans.
        """
        ahead = self._ahead
        motion = self._motion(plan, time + ahead.position)
        posture = self._at(plan, time + ahead.arm)[0][5:]
        arm_rates = (posture - arm_angles) / ahead.arm
        return Setpoint(
            position=motion.position,
            velocity=motion.velocity,
            acceleration=self._acceleration(plan, time + ahead.acceleration),
            yaw=float(self._at(plan, time + ahead.attitude)[0][2]),
            force=self._force(plan, time + ahead.attitude),
            normal=self.model.door.normal(self._at(plan, time)[0][3]),
            arm_rates=np.minimum(np.maximum(arm_rates, -self._rate_limits), self._rate_limits),
        )

    def door_rate(self, plan: Plan, time: float) -> float:
        """Rate α̇ of the door at a time of the plan, 0 after its end [rad/s]."""
        return float(self._at(plan, time)[0][4])

    def _motion(self, plan: Plan, time: float) -> VehicleMotion:
        """Position and velocity of O_B at a time of the plan."""
        state, inputs = self._at(plan, time)
        return self._coupling.vehicle_motion(state, inputs[1:4], inputs[4 : 4 + self.model.n_arm])

    def _acceleration(self, plan: Plan, time: float) -> Array:
        """Acceleration of O_B at a time of the plan, by central differences over four steps, fewer at its ends.

        The posture's part counts: yawing about the tied tip is swinging the vehicle's mass about it.
        """
        half, end = 2.0 * plan.time_step, plan.time_step * len(plan.inputs)
        before, after = max(time - half, 0.0), min(time + half, end * (1.0 - 1e-9))
        if after <= before:
            return np.zeros(3)
        change = self._motion(plan, after).velocity - self._motion(plan, before).velocity
        return np.asarray(change / (after - before))

    def _force(self, plan: Plan, time: float) -> Array:
        """`planned_force` at a time of the plan; none after its end."""
        if time >= plan.time_step * len(plan.inputs):
            return np.zeros(3)
        state, inputs = self._at(plan, time)
        acceleration = self._acceleration(plan, time) if self._planning.moved_mass > 0.0 else None
        return self.planned_force(state, float(inputs[0]), acceleration, inputs[4 + self.model.n_arm :])

    def _at(self, plan: Plan, time: float) -> tuple[Array, Array]:
        """Reduced state and inputs at a time of the plan; at rest after its end."""
        last = len(plan.inputs)
        at = min(max(time / plan.time_step, 0.0), float(last))
        node = min(int(at), last - 1)
        part = at - node
        between = (1.0 - part) * plan.states[node] + part * plan.states[node + 1]
        state, inputs = self._planning.reduced(between, plan.inputs[node])
        if at >= last:
            state[4] = 0.0
            return state, np.zeros_like(inputs)  # no force to feed forward, no rates
        return state, inputs

    def hold(self, position: Array, yaw: float) -> Setpoint:
        """Setpoint that keeps a position at rest."""
        rest = np.zeros(3)
        return Setpoint(position.copy(), rest, rest, yaw, rest, rest, np.zeros(self.model.n_arm))

    def planned_force(
        self, state: Array, thrust: float, acceleration: Array | None = None, side: Array | None = None
    ) -> Array:
        """Part along the door's normal of the planned force on the door (`PlanningModel.moved_mass`)."""
        normal = self.model.door.normal(state[3])
        rotors = np.array([0.0, 0.0, thrust])
        if side is not None and len(side):
            rotors[:2] = side
        force = rotation_body_to_world(state[:3]) @ rotors - [0.0, 0.0, self.model.vehicle.weight]
        if acceleration is not None:
            force = force - self._planning.moved_mass * acceleration
        return np.asarray((normal @ force) * normal)
