"""State converter: measurements to the planner's state, and plans to setpoints of the position controller."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.control.position_controller import Setpoint
from doorman.kinematics.coupling import VehicleMotion
from doorman.kinematics.door import door_normal
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import GRAVITY, Model
from doorman.ocp.planner import Plan

Array = NDArray[np.float64]


class StateConverter:
    """Both directions between vehicle and planner, by the kinematic constraint.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self._coupling = model.coupling
        self._rate_limits = np.asarray(model.vehicle.rate_limits)
        rest = np.zeros(3)
        self._coupling.vehicle_motion(model.start_state, rest, np.zeros(model.n_arm))  # compiles: nothing is in flight

    def state(
        self,
        position: ArrayLike,
        velocity: ArrayLike,
        attitude: ArrayLike,
        body_rates: ArrayLike,
        arm_angles: ArrayLike,
        arm_rates: ArrayLike,
    ) -> Array:
        """The planner's state; the door's part comes from the tip.

        Args:
            position: P, shape (3,), world frame [m].
            velocity: Ṗ, shape (3,), world frame [m/s].
            attitude: Φ, shape (3,) [rad].
            body_rates: Ω, shape (3,), body frame [rad/s].
            arm_angles: H, shape (n,) [rad].
            arm_rates: Ḣ, shape (n,) [rad/s].

        Returns:
            x = [Φ, α, α̇, H], shape (5 + n,).
        """
        angle, rate = self._coupling.door_state(position, velocity, attitude, body_rates, arm_angles, arm_rates)
        return np.concatenate([np.asarray(attitude), [angle, rate], np.asarray(arm_angles)])

    def setpoint(self, plan: Plan, time: float, arm_angles: Array) -> Setpoint:
        """Setpoint for a time of the plan; after its end, the last state at rest.

        Each part is taken from the plan as much later as the loop that follows it lags behind (`control.*_look_ahead`).
        Joint rates lead from the measured posture to the plan's, so that a correction which the plan makes in its first
        step is not lost between two plans.

        Args:
            plan: A usable plan.
            time: Since the plan's first state [s].
            arm_angles: H now, shape (n,) [rad].

        Returns:
            The setpoint, by linear interpolation between nodes.
        """
        settings = self.model.scenario.control
        motion = self._motion(plan, time + settings.position_look_ahead)
        state, inputs = self._at(plan, time + settings.attitude_look_ahead)
        posture = self._at(plan, time + settings.arm_look_ahead)[0][5:]
        arm_rates = (posture - arm_angles) / settings.arm_look_ahead
        return Setpoint(
            position=motion.position,
            velocity=motion.velocity,
            acceleration=self._acceleration(plan, time + settings.acceleration_look_ahead),
            yaw=float(state[2]),
            force=self.planned_force(state, float(inputs[0])),
            normal=door_normal(self._at(plan, time)[0][3]),
            arm_rates=np.clip(arm_rates, -self._rate_limits, self._rate_limits),
        )

    def _motion(self, plan: Plan, time: float) -> VehicleMotion:
        """Position and velocity of O_B at a time of the plan."""
        state, inputs = self._at(plan, time)
        return self._coupling.vehicle_motion(state, inputs[1:4], inputs[4:])

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

    @staticmethod
    def _at(plan: Plan, time: float) -> tuple[Array, Array]:
        """State and inputs at a time of the plan; at rest after its end."""
        last = len(plan.inputs)
        at = min(max(time / plan.time_step, 0.0), float(last))
        node = min(int(at), last - 1)
        part = at - node
        state = (1.0 - part) * plan.states[node] + part * plan.states[node + 1]
        if at >= last:
            state[4] = 0.0
            return state, np.zeros(plan.inputs.shape[1])  # no force to feed forward, no rates
        return state, plan.inputs[node]

    def hold(self, position: Array, yaw: float) -> Setpoint:
        """Setpoint that keeps a position at rest.

        Args:
            position: P, shape (3,), world frame [m].
            yaw: ψ [rad].
        """
        rest = np.zeros(3)
        return Setpoint(position.copy(), rest, rest, yaw, rest, rest, np.zeros(self.model.n_arm))

    def planned_force(self, state: Array, thrust: float) -> Array:
        r"""Horizontal part, along the door's normal, of :math:`F_R = f_t R e_3 - m_A g e_3`.

        Args:
            state: x, shape (5 + n,).
            thrust: f_t [N].

        Returns:
            Force on the door, shape (3,), world frame [N].
        """
        force = thrust * rotation_body_to_world(state[:3])[:, 2]
        force[2] -= self.model.vehicle.mass * GRAVITY
        normal = door_normal(state[3])
        return np.asarray((normal @ force) * normal)
