"""State converter: measurements to the planner's state, and plans to setpoints of the position controller."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.control.position_controller import Setpoint
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

    def setpoint(self, plan: Plan, time: float) -> Setpoint:
        """Setpoint at a time of the plan; after its end, the last state at rest.

        Args:
            plan: A usable plan.
            time: Since the plan's first state [s].

        Returns:
            The setpoint, by linear interpolation between nodes.
        """
        last = len(plan.inputs)
        at = min(max(time / plan.time_step, 0.0), float(last))
        node = min(int(at), last - 1)
        part = at - node
        state = (1.0 - part) * plan.states[node] + part * plan.states[node + 1]
        inputs = plan.inputs[node]
        if at >= last:
            inputs = np.concatenate([inputs[:1], np.zeros(len(inputs) - 1)])
            state[4] = 0.0
        motion = self._coupling.vehicle_motion(state, inputs[1:4], inputs[4:])
        acceleration = (plan.states[node + 1, 4] - plan.states[node, 4]) / plan.time_step if at < last else 0.0
        return Setpoint(
            position=motion.position,
            velocity=motion.velocity,
            acceleration=self._contact_acceleration(state, acceleration),
            yaw=float(state[2]),
            force=self.planned_force(state, float(inputs[0])),
            arm_rates=np.clip(inputs[4:], -self._rate_limits, self._rate_limits),
        )

    def hold(self, position: Array, yaw: float) -> Setpoint:
        """Setpoint that keeps a position at rest.

        Args:
            position: P, shape (3,), world frame [m].
            yaw: ψ [rad].
        """
        rest = np.zeros(3)
        return Setpoint(position.copy(), rest, rest, yaw, rest, np.zeros(self.model.n_arm))

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
        normal = np.array([math.sin(state[3]), -math.cos(state[3]), 0.0])
        return np.asarray((normal @ force) * normal)

    def _contact_acceleration(self, state: Array, door_acceleration: float) -> Array:
        """Acceleration of the contact point on its circle; that of the posture about it is left to feedback."""
        sine, cosine = math.sin(state[3]), math.cos(state[3])
        radius = self._coupling.distance_from_hinge
        tangential, central = radius * door_acceleration, radius * state[4] ** 2
        return np.array([-sine * tangential - cosine * central, cosine * tangential - sine * central, 0.0])
