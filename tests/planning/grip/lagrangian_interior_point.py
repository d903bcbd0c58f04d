"""An independent solution of the door problem with full dynamics: Lagrange's equations by CasADi's derivatives, and IPOPT.

Nothing here calls doorman's kernels, or uses its equations of motion: they follow from the kinetic and potential energy of
vehicle and leaf, with the vehicle's place given by the tip.
"""

from __future__ import annotations

from functools import cached_property

import casadi as ca
import numpy as np
from interior_point import InteriorPointReference, rotation

from doorman.planning.pace import time_constant_held


class LagrangianReference(InteriorPointReference):
    """The same optimal control problem as `lagrangian_problem`, by multiple shooting and IPOPT.

    Args:
        model: doorman.Model, for its numbers only.
        disturbance: Further torque in the hinge, in the sense of damping [N m].
    """

    expand = False

    def _goals(self) -> tuple[np.ndarray, np.ndarray]:
        goal = self._goal()
        return np.array([*goal[:4], 0.0, 0.0, 0.0, *goal[4:]]), np.array(self.model.hover_input)

    def _weights(self) -> tuple[ca.DM, ca.DM, ca.DM]:
        """The paper's; 5, 5 and 13.5 on Φ̇, and 0.1 on torques."""
        n, held = self.model.n_arm, 9.0 * time_constant_held(self.model) ** 2
        state = ca.DM([5, 5, 3, 9, 5, 5, 13.5, held, *([0.05] + [0.1] * n)[:n]])
        return state, state, ca.DM([0.1, 0.1, 0.1, 0.1, *[10.0] * n])

    def _rows(self, x: ca.SX) -> list[ca.SX]:
        """Those of the simplified dynamics, and ±Ω beyond its limits, from the attitude's derivative."""
        attitude, limit = rotation(x[:3]), ca.DM(list(self.model.scenario.limits.body_rates))
        turning = attitude.T @ ca.reshape(ca.jtimes(ca.vec(attitude), x[:3], x[4:7]), 3, 3)
        rates = ca.vertcat(turning[2, 1], turning[0, 2], turning[1, 0])
        return [*super()._rows(ca.vertcat(x[:4], x[7:])), rates - limit, -rates - limit]

    def _limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Of [u, x]: those of the simplified dynamics without the body rates."""
        ends = np.array(super()._limits())
        free, n = np.array([[-np.inf] * 3, [np.inf] * 3]), 4 + self.model.n_arm
        low, high = np.hstack([ends[:, :1], free, ends[:, 4:n], free, ends[:, n:]])
        return low, high

    def _rates(self, x: ca.SX, u: ca.SX) -> ca.SX:
        return self._dynamics(x, u)

    @cached_property
    def _dynamics(self) -> ca.Function:
        """ẋ by d/dt ∂L/∂q̇ − ∂L/∂q = Q for q = [Φ, α], the arm locked."""
        model, door = self.model, self.model.door
        x, u = ca.SX.sym("x", 8 + model.n_arm), ca.SX.sym("u", 4 + model.n_arm)
        q, speed, arm = ca.SX.sym("q", 4), ca.SX.sym("dq", 4), ca.SX.sym("H", model.n_arm)
        attitude, angle = rotation(q[:3]), q[3]
        contact = model.scenario.contact
        reach = contact.distance_from_hinge
        place = (
            ca.vertcat(reach * ca.cos(angle), reach * ca.sin(angle), contact.height) - attitude @ self.points(arm)[-1]
        )
        velocity = ca.jtimes(place, q, speed)
        turning = attitude.T @ ca.reshape(ca.jtimes(ca.vec(attitude), q, speed), 3, 3)
        body_rates = ca.vertcat(turning[2, 1], turning[0, 2], turning[1, 0])
        inertia = ca.DM(model.vehicle.inertia(model.goal_arm))
        kinetic = 0.5 * (model.vehicle.mass * ca.dot(velocity, velocity) + door.inertia * speed[3] ** 2)
        kinetic += 0.5 * ca.dot(body_rates, inertia @ body_rates)
        potential = model.vehicle.mass * 9.81 * place[2] + 0.5 * door.stiffness * (angle - door.rest_angle) ** 2
        momentum = ca.gradient(kinetic, speed)
        thrust = ca.jacobian(place, q).T @ attitude[:, 2] * u[0]
        torque = ca.jacobian(body_rates, speed).T @ u[1:4]
        hinge = door.damping * speed[3] + door.friction * ca.tanh(speed[3] / door.friction_rate) + self.disturbance
        force = thrust + torque - ca.vertcat(0, 0, 0, hinge)
        bias = ca.jtimes(momentum, q, speed) - ca.gradient(kinetic - potential, q)
        acceleration = ca.solve(ca.jacobian(momentum, speed), force - bias)
        rates = ca.Function("q", [q, speed, arm, u], [acceleration])(x[:4], x[4:8], x[8:], u)
        return ca.Function("rates", [x, u], [ca.vertcat(x[4:8], rates, u[4:])])
