"""State converter: measurements to the planner's state, and plans to setpoints of the position controller."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.control.position_controller import Setpoint
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
        """Setpoint for a time of the plan; after its end, the last state at rest.

        Position and velocity are those `control.look_ahead` later; yaw, force and acceleration, which act through the
        attitude loop, those `control.attitude_look_ahead` later.

        Args:
            plan: A usable plan.
            time: Since the plan's first state [s].

        Returns:
            The setpoint, by linear interpolation between nodes.
        """
        settings = self.model.scenario.control
        state, inputs, _ = self._at(plan, time + settings.look_ahead)
        motion = self._coupling.vehicle_motion(state, inputs[1:4], inputs[4:])
        later, later_inputs, door_acceleration = self._at(plan, time + settings.attitude_look_ahead)
        return Setpoint(
            position=motion.position,
            velocity=motion.velocity,
            acceleration=self._contact_acceleration(later, door_acceleration),
            yaw=float(later[2]),
            force=self.planned_force(later, float(later_inputs[0])),
            arm_rates=np.clip(inputs[4:], -self._rate_limits, self._rate_limits),
            normal=door_normal(state[3]),
        )

    @staticmethod
    def _at(plan: Plan, time: float) -> tuple[Array, Array, float]:
        """State, inputs and door acceleration at a time of the plan; at rest after its end."""
        last = len(plan.inputs)
        at = min(max(time / plan.time_step, 0.0), float(last))
        node = min(int(at), last - 1)
        part = at - node
        state = (1.0 - part) * plan.states[node] + part * plan.states[node + 1]
        if at >= last:
            state[4] = 0.0
            return state, np.concatenate([plan.inputs[-1, :1], np.zeros(plan.inputs.shape[1] - 1)]), 0.0
        return state, plan.inputs[node], float(plan.states[node + 1, 4] - plan.states[node, 4]) / plan.time_step

    def hold(self, position: Array, yaw: float) -> Setpoint:
        """Setpoint that keeps a position at rest.

        Args:
            position: P, shape (3,), world frame [m].
            yaw: ψ [rad].
        """
        rest = np.zeros(3)
        return Setpoint(position.copy(), rest, rest, yaw, rest, np.zeros(self.model.n_arm), rest)

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

    def _contact_acceleration(self, state: Array, door_acceleration: float) -> Array:
        """Acceleration of the contact point on its circle; that of the posture about it is left to feedback."""
        sine, cosine = math.sin(state[3]), math.cos(state[3])
        radius = self._coupling.distance_from_hinge
        tangential, central = radius * door_acceleration, radius * state[4] ** 2
        return np.array([-sine * tangential - cosine * central, cosine * tangential - sine * central, 0.0])
