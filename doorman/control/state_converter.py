"""State converter: measurements to states, and plans, whatever their model, to setpoints of the position controller."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.control.kernels.on_leaf import vehicle_on_leaf
from doorman.control.kernels.tip import ARM, tip_on_leaf
from doorman.control.position_controller import Setpoint
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.kinematics.coupling import VehicleMotion
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_numbers
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.arms.arm import ArmParameters
from doorman.model import Model
from doorman.numba_types.handles import held
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
    """Both directions between vehicle and planner, by the kinematic constraint."""

    def __init__(self, model: Model, ahead: LookAheads | None = None) -> None:
        self.model = model
        self._ahead = ahead or LookAheads.of(model.attitude_loop)
        self._planning = planning_model(model)
        self._coupling = model.coupling
        self._arm, self._leaf = held(ArmParameters.of(model.vehicle.arm)), leaf_numbers(model.door)
        self._given, self._tip = np.zeros(ARM + 2 * model.n_arm), np.zeros(6)
        self._contact = np.array([*model.door.up, self._coupling.distance_from_hinge, self._coupling.height])
        self._rate_limits = np.asarray(model.vehicle.rate_limits)
        rest = np.zeros(3)
        self.on_leaf(np.array(model.start_state), rest, np.zeros(model.n_arm))  # compiles: nothing is in flight
        self._coupling.vehicle_motion(model.start_state, rest, np.zeros(model.n_arm))
        tip_on_leaf(self._arm, self._leaf, self._coupling.lever_length, self._given, self._tip)
        self._coupling.tips(rest[None], np.zeros((1, model.n_arm)))

    @property
    def at_the_tip(self) -> tuple[ArmParameters, Array, Array, float]:
        """Arm, leaf, contact and lever, as kernels read them."""
        return self._arm, self._leaf, self._contact, self._coupling.lever_length

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another attitude loop from now on."""
        self._ahead = LookAheads.of(loop)

    def state(
        self,
        position: ArrayLike,
        velocity: ArrayLike,
        attitude: ArrayLike,
        body_rates: ArrayLike,
        arm_angles: ArrayLike,
        arm_rates: ArrayLike,
    ) -> Array:
        """The reduced state; the door's part comes from the tip."""
        angle, rate = self._coupling.door_state(position, velocity, attitude, body_rates, arm_angles, arm_rates)
        return np.concatenate([np.asarray(attitude), [angle, rate], np.asarray(arm_angles)])

    def on_leaf(self, state: Array, body_rates: Array, arm_rates: Array) -> VehicleMotion:
        """Position and velocity of O_B with the tip at the contact point, see `Coupling.vehicle_motion`."""
        motion = np.empty(6)
        vehicle_on_leaf(self._arm, self._leaf, self._contact, state, body_rates, arm_rates, motion)
        return VehicleMotion(motion[:3], motion[3:])

    def tip(self, *seen: Array) -> tuple[float, float]:
        """Angle and angular rate of the tip about the hinge: the door's, where they touch.

        Takes position, velocity, attitude, body rates, joint angles and rates.
        """
        np.concatenate(seen, out=self._given)
        angle, rate = tip_on_leaf(self._arm, self._leaf, self._coupling.lever_length, self._given, self._tip)
        if not math.isfinite(angle + rate):
            return self._coupling.door_state(*seen)  # says what is not finite
        return angle, rate

    def tip_offset(self, position: Array, state: Array) -> tuple[float, float]:
        """Where the tip is on the leaf, relative to the contact point."""
        coupling = self._coupling
        tip = position + rotation_body_to_world(state[:3]) @ self.model.vehicle.tip_position(state[5:])
        off = tip - coupling.contact_point(state[3])
        aside, upwards = self.model.door.face(state[3])
        return float(aside @ off), float(upwards @ off)

    def planner_state(self, state: Array, body_rates: ArrayLike) -> Array:
        """State that the planner starts from."""
        return self._planning.state(state, body_rates)

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
            yaw=self.heading(plan, time + ahead.attitude),
            force=self._force(plan, time + ahead.attitude),
            normal=self.model.door.normal(self._at(plan, time)[0][3]),
            arm_rates=np.minimum(np.maximum(arm_rates, -self._rate_limits), self._rate_limits),
        )

    def door_rate(self, plan: Plan, time: float) -> float:
        """Rate α̇ of the door at a time of the plan, 0 after its end [rad/s]."""
        return float(self._at(plan, time)[0][4])

    def heading(self, plan: Plan, time: float) -> float:
        """Heading ψ of the vehicle at a time of the plan [rad]."""
        return float(self._at(plan, time)[0][2])

    def _motion(self, plan: Plan, time: float) -> VehicleMotion:
        """Position and velocity of O_B at a time of the plan."""
        state, inputs = self._at(plan, time)
        body_rates, arm_rates = (
            inputs[1:4].copy(),
            inputs[4 : 4 + self.model.n_arm].copy(),
        )  # kernels take writable arrays
        return self.on_leaf(state, body_rates, arm_rates)

    def _acceleration(self, plan: Plan, time: float) -> Array:
        """Acceleration of O_B at a time of the plan, by central differences over four steps, fewer at its ends.

        The posture's part counts: yawing about the tied tip is swinging the vehicle's mass about it.
        """
        before, after = self._around(plan, time)
        if after <= before:
            return np.zeros(3)
        change = self._motion(plan, after).velocity - self._motion(plan, before).velocity
        return np.asarray(change / (after - before))

    @staticmethod
    def _around(plan: Plan, time: float) -> tuple[float, float]:
        """Two times of the plan around one, four steps apart where it goes on so long."""
        half, end = 2.0 * plan.time_step, plan.time_step * len(plan.inputs)
        return max(time - half, 0.0), min(time + half, end * (1.0 - 1e-9))

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
