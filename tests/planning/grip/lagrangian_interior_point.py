"""An independent solution of the door problem with full dynamics: Lagrange's equations by CasADi's derivatives, and IPOPT.

Nothing here calls doorman's kernels, or uses its equations of motion: they follow from the kinetic and potential energy of
vehicle and leaf, with the vehicle's place given by the tip.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np
from interior_point import InteriorPointReference, Reference, axis_rotation, rotation

from doorman.planning.pace import time_constant_held


class LagrangianReference(InteriorPointReference):
    """The same optimal control problem as `lagrangian_problem`, by multiple shooting and IPOPT.

    Args:
        model: doorman.Model, for its numbers only.
        disturbance: Further torque in the hinge, in the sense of damping [N m].
    """

    def __init__(self, model: Any, disturbance: float = 0.0) -> None:
        self.model, self.disturbance = model, disturbance
        planner = model.scenario.planner
        self.n, self.dt, self.margin = planner.horizon_steps, planner.time_step, planner.margin
        self.nx, self.nu = 8 + model.n_arm, 4 + model.n_arm
        goal, posture = self._goal(), ca.SX.sym("x", self.nx)
        self.state_goal = np.array([*goal[:4], 0.0, 0.0, 0.0, goal[4], *goal[5:]])
        self.input_goal = np.array([model.vehicle.mass * 9.81, *np.zeros(3 + model.n_arm)])
        self.rates = self._rates_function()
        step = self._step_function()
        reduced = ca.vertcat(posture[:4], posture[7:])
        tilt = np.cos(model.scenario.limits.tilt) - ca.cos(posture[0]) * ca.cos(posture[1])
        limited = self._over_body_rates(posture)
        rows = ca.Function("h", [posture], [ca.vertcat(self.constraints(reduced) + self.margin, tilt, limited)])
        start, variables = ca.MX.sym("x0", self.nx), ca.MX.sym("z", (self.nu + self.nx) * self.n)
        nodes = ca.reshape(variables, self.nu + self.nx, self.n)
        inputs, states = nodes[: self.nu, :], nodes[self.nu :, :]
        before = ca.horzcat(start, states[:, :-1])
        equal, bounded = states - step.map(self.n)(before, inputs), rows.map(self.n)(states)
        problem = {
            "x": variables, "p": start, "f": self._cost(before, inputs, states[:, -1]),
            "g": ca.vec(ca.vertcat(equal, bounded)),
        }  # fmt: skip
        one = np.concatenate([np.zeros(self.nx), np.full(rows.size1_out(0), -np.inf)])
        self._lower = np.tile(one, self.n)
        settings = {
            "ipopt.tol": 1e-9, "ipopt.constr_viol_tol": 1e-9, "ipopt.acceptable_tol": 1e-9, "ipopt.print_level": 0,
            "ipopt.max_iter": 300, "ipopt.bound_relax_factor": 0.0, "ipopt.sb": "yes", "print_time": False,
        }  # fmt: skip
        self._solver = ca.nlpsol("door", "ipopt", problem, settings)

    def solve(self, state: np.ndarray, guess: Reference | None = None) -> Reference:
        """Solve from hover inputs and the state held, or from a guess."""
        inputs = np.tile(self.input_goal, (self.n, 1)) if guess is None else guess.inputs
        states = np.tile(state, (self.n, 1)) if guess is None else guess.states[1:]
        lower, upper = (np.tile(ends, self.n) for ends in self._bounds())
        first = np.hstack([inputs, states]).ravel()
        result = self._solver(x0=first, p=state, lbg=self._lower, ubg=0.0, lbx=lower, ubx=upper)
        z = np.array(result["x"]).reshape(self.n, self.nu + self.nx)
        success = bool(self._solver.stats()["success"])
        return Reference(np.vstack([state, z[:, self.nu :]]), z[:, : self.nu], float(result["f"]), success)

    def _over_body_rates(self, x: ca.SX) -> ca.SX:
        """±Ω beyond its limits, from the attitude's derivative."""
        attitude, limit = rotation(x[:3]), ca.DM(list(self.model.scenario.limits.body_rates))
        turning = attitude.T @ ca.reshape(ca.jtimes(ca.vec(attitude), x[:3], x[4:7]), 3, 3)
        rates = ca.vertcat(turning[2, 1], turning[0, 2], turning[1, 0])
        return ca.vertcat(rates - limit, -rates - limit)

    def _bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Of [u, x]: thrust, joint rates and joint angles."""
        limits, vehicle = self.model.scenario.limits, self.model.vehicle
        others, free = np.full(8, np.inf), np.full(3, np.inf)
        joints = np.array(vehicle.rate_limits)
        if limits.joint_rates is not None:
            joints[:] = limits.joint_rates
        lower = [[limits.min_thrust], -free, -joints, -others, vehicle.lower_limits]
        upper = [[vehicle.max_thrust], free, joints, others, vehicle.upper_limits]
        return np.concatenate(lower), np.concatenate(upper)

    def _cost(self, before: ca.MX, inputs: ca.MX, last: ca.MX) -> ca.MX:
        """J, its weights written out: the paper's; 5, 5 and 13.5 on Φ̇, and 0.1 on torques."""
        n = self.model.n_arm
        arm = ([0.05] + [0.1] * n)[:n]
        held = 9.0 * time_constant_held(self.model) ** 2
        by_state = ca.DM([5, 5, 3, 9, 5, 5, 13.5, held, *arm])
        by_input = ca.DM([0.1, 0.1, 0.1, 0.1, *[10.0] * n])
        error = before - ca.repmat(ca.DM(self.state_goal), 1, self.n)
        effort = inputs - ca.repmat(ca.DM(self.input_goal), 1, self.n)
        running = ca.dot(by_state, ca.sum2(error**2)) + ca.dot(by_input, ca.sum2(effort**2))
        return 0.5 * (self.dt * running + ca.dot(by_state, (last - ca.DM(self.state_goal)) ** 2))

    def _step_function(self) -> ca.Function:
        x, u, h = ca.SX.sym("x", self.nx), ca.SX.sym("u", self.nu), self.dt
        k1 = self.rates(x, u)
        k2 = self.rates(x + h / 2 * k1, u)
        k3 = self.rates(x + h / 2 * k2, u)
        k4 = self.rates(x + h * k3, u)
        return ca.Function("f", [x, u], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])

    def _rates_function(self) -> ca.Function:
        """ẋ by d/dt ∂L/∂q̇ − ∂L/∂q = Q for q = [Φ, α], the arm locked."""
        model, door = self.model, self.model.door
        x, u = ca.SX.sym("x", self.nx), ca.SX.sym("u", self.nu)
        q, speed, arm = ca.SX.sym("q", 4), ca.SX.sym("dq", 4), ca.SX.sym("H", model.n_arm)
        attitude, angle = rotation(q[:3]), q[3]
        contact = model.scenario.contact
        reach = contact.distance_from_hinge
        place = ca.vertcat(reach * ca.cos(angle), reach * ca.sin(angle), contact.height) - attitude @ self._tip(arm)
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

    def _tip(self, angles: ca.SX) -> ca.SX:
        """Position of the tip in the body by homogeneous transforms."""
        arm = self.model.vehicle.arm
        turn, origin = ca.SX.eye(3), ca.SX.zeros(3)
        joints = []
        for i in range(self.model.n_arm):
            origin = origin + turn @ ca.DM(np.array(arm.links[i]))
            turn = turn @ axis_rotation(np.array(arm.axes[i]), angles[i])
            joints.append((turn, origin))
        turn, origin = joints[arm.point_parents[-1]]
        return origin + turn @ ca.DM(np.array(arm.point_offsets[-1]))
