"""An independent solution of the door problem: CasADi expressions written from the equations, solved by IPOPT.

Nothing here calls doorman's kernels. Only numbers are taken from the model (mass, lengths, weights).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from doorman.planning.pace import time_constant_held


@dataclass(frozen=True)
class Reference:
    """Optimum found by IPOPT."""

    states: np.ndarray
    inputs: np.ndarray
    cost: float
    success: bool
    price: float = 0.0
    """Largest multiplier of an inequality: what a unit of its violation would save."""


class InteriorPointReference:
    """The same optimal control problem as `door_problem`, limits included, by multiple shooting and IPOPT.

    Args:
        model: doorman.Model, for its numbers only.
        disturbance: Further torque against opening [N m].
        options: More options of nlpsol, for example to generate and compile C.
    """

    expand = True
    """Whether IPOPT's functions are unrolled: quicker where the dynamics are short."""

    def __init__(self, model: Any, disturbance: float = 0.0, options: dict[str, Any] | None = None) -> None:
        self.model = model
        self.disturbance = disturbance
        planner = model.scenario.planner
        self.n, self.dt, self.margin = planner.horizon_steps, planner.time_step, planner.margin
        goals, weights, limits = self._goals(), self._weights(), model.scenario.limits
        self.input_goal = goals[1]
        self.nx, self.nu = (len(goal) for goal in goals)
        x, u = ca.SX.sym("x", self.nx), ca.SX.sym("u", self.nu)
        step = ca.Function("f", [x, u], [self._rk4(x, u)])
        rows = ca.Function("h", [x], [ca.vertcat(*self._rows(x))])
        start, variables = ca.MX.sym("x0", self.nx), ca.MX.sym("z", (self.nu + self.nx) * self.n)
        nodes = ca.reshape(variables, self.nu + self.nx, self.n)
        inputs, states = nodes[: self.nu, :], nodes[self.nu :, :]
        before = ca.horzcat(start, states[:, :-1])
        error, effort = (
            each - ca.repmat(ca.DM(goal), 1, self.n) for each, goal in zip((before, inputs), goals, strict=True)
        )
        running = ca.dot(weights[0], ca.sum2(error**2)) + ca.dot(weights[2], ca.sum2(effort**2))
        cost = 0.5 * (self.dt * running + ca.dot(weights[1], (states[:, -1] - ca.DM(goals[0])) ** 2))
        kept = ca.vertcat(states - step.map(self.n)(before, inputs), rows.map(self.n)(states))
        one = np.concatenate([np.zeros(self.nx), np.full(rows.size1_out(0), -np.inf)])
        self._lower = np.tile(one, self.n)
        ends = self._limits() if limits.enabled else (np.full(self.nx + self.nu, end) for end in (-np.inf, np.inf))
        self._bounds = [np.tile(end, self.n) for end in ends]
        settings = {
            "ipopt.tol": 1e-9, "ipopt.constr_viol_tol": 1e-9, "ipopt.acceptable_tol": 1e-9, "ipopt.print_level": 0,
            "ipopt.max_iter": 500, "ipopt.bound_relax_factor": 0.0, "ipopt.sb": "yes", "print_time": False,
            "expand": self.expand, **(options or {}),
        }  # fmt: skip
        problem = {"x": variables, "p": start, "f": cost, "g": ca.vec(kept)}
        self._solver = ca.nlpsol("door", "ipopt", problem, settings)

    def _goals(self) -> tuple[np.ndarray, np.ndarray]:
        """Of states and inputs."""
        return self._goal(), np.array(self.model.hover_input)

    def _rows(self, x: ca.SX) -> list[ca.SX]:
        """Collision constraints with margin, and the tilt."""
        limits = self.model.scenario.limits
        tilt = [ca.cos(limits.tilt) - ca.cos(x[0]) * ca.cos(x[1])] if limits.enabled else []
        return [self.constraints(x) + self.margin, *tilt]

    def _goal(self) -> np.ndarray:
        """With the attitude whose thrust carries the weight and pushes with −τ_d/D_V along the door's normal."""
        goal, push = np.array(self.model.goal_state), -self.disturbance / self.model.coupling.distance_from_hinge
        turn = goal[3] - goal[2]
        thrust = np.array([push * np.sin(turn), -push * np.cos(turn), self.model.vehicle.mass * 9.81])
        thrust /= np.linalg.norm(thrust)
        goal[:2] += np.arcsin(-thrust[1]), np.arctan2(thrust[0], thrust[2])
        return goal

    def solve(self, state: np.ndarray, guess: Reference | None = None) -> Reference:
        """Solve from hover inputs and the state held, or from a guess."""
        if guess is None:
            inputs = np.tile(self.input_goal, (self.n, 1))
            states = np.tile(state, (self.n, 1))
        else:
            inputs, states = guess.inputs, guess.states[1:]
        first = np.hstack([inputs, states]).ravel()
        low, high = self._bounds
        result = self._solver(x0=first, p=state, lbx=low, ubx=high, lbg=self._lower, ubg=0.0)
        z = np.array(result["x"]).reshape(self.n, self.nu + self.nx)
        success = bool(self._solver.stats()["success"])
        of_rows = np.array(result["lam_g"]).ravel()[np.isinf(self._lower)]
        price = max(of_rows.max(), np.abs(np.array(result["lam_x"])).max())
        return Reference(
            np.vstack([state, z[:, self.nu :]]), z[:, : self.nu], float(result["f"]), success, float(price)
        )

    def _limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds of one node's [f_t, Ω, Ḣ_d, Φ, α, α̇, H]."""
        limits, vehicle = self.model.scenario.limits, self.model.vehicle
        given = limits.joint_rates
        rates = np.array(vehicle.rate_limits) if given is None else np.full(self.model.n_arm, given)
        high = np.concatenate(
            [[vehicle.max_thrust], limits.body_rates, rates, np.full(5, np.inf), vehicle.upper_limits]
        )
        low = np.concatenate([[0.0], -np.array(limits.body_rates), -rates, np.full(5, -np.inf), vehicle.lower_limits])
        return low, high

    def _weights(self) -> tuple[ca.DM, ca.DM, ca.DM]:
        given, n = self.model.scenario.planner.weights, self.model.n_arm
        held = 9.0 * time_constant_held(self.model) ** 2
        arm = ([0.05] + [0.1] * n)[:n]
        state = list(given.state or [5, 5, 3, 9, held, *arm])
        return ca.DM(state), ca.DM(state), ca.DM(list(given.input or [0.1, 5, 5, 13.5, *[10.0] * n]))

    def _rk4(self, x: ca.SX, u: ca.SX) -> ca.SX:
        k1 = self._rates(x, u)
        k2 = self._rates(x + self.dt / 2 * k1, u)
        k3 = self._rates(x + self.dt / 2 * k2, u)
        k4 = self._rates(x + self.dt * k3, u)
        return x + self.dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4)

    def _rates(self, x: ca.SX, u: ca.SX) -> ca.SX:
        door, contact = self.model.door, self.model.scenario.contact
        roll, pitch, angle, rate = x[0], x[1], x[3], x[4]
        euler = ca.vertcat(
            ca.horzcat(1, ca.sin(roll) * ca.tan(pitch), ca.cos(roll) * ca.tan(pitch)),
            ca.horzcat(0, ca.cos(roll), -ca.sin(roll)),
            ca.horzcat(0, ca.sin(roll) / ca.cos(pitch), ca.cos(roll) / ca.cos(pitch)),
        )
        normal = ca.vertcat(ca.sin(angle), -ca.cos(angle), 0)
        force = u[0] * rotation(x[:3])[:, 2] - ca.vertcat(0, 0, self.model.vehicle.mass * 9.81)
        torque = (
            door.damping * rate + door.friction * ca.tanh(rate / door.friction_rate)
            + door.stiffness * (angle - door.rest_angle) + self.disturbance
        )  # fmt: skip
        acceleration = -(contact.distance_from_hinge * ca.dot(normal, force) + torque) / door.inertia
        return ca.vertcat(euler @ u[1:4], rate, acceleration, u[4:])

    def constraints(self, x: ca.SX) -> ca.SX:
        """h(x), from the geometry, the disc by its support function."""
        door, contact, radius = self.model.door, self.model.scenario.contact, self.model.vehicle.radius
        points = self.points(x[5:])
        attitude, angle, tip = rotation(x[:3]), x[3], points[-1]
        normal = ca.vertcat(ca.sin(angle), -ca.cos(angle), 0)
        in_body = attitude.T @ normal
        disc = radius * ca.sqrt(in_body[0] ** 2 + in_body[1] ** 2)
        across = (attitude @ tip)[1]
        side = contact.distance_from_hinge * ca.sin(angle)
        return ca.vertcat(
            *[p[2] for p in points],
            disc - ca.dot(in_body, tip),
            side - door.width + radius - across,
            across - side + radius,
        )

    def points(self, angles: ca.SX) -> list[ca.SX]:
        """Points of the arm in the body by homogeneous transforms, the tip last."""
        arm, turn, origin, joints = self.model.vehicle.arm, ca.SX.eye(3), ca.SX.zeros(3), []
        for i in range(self.model.n_arm):
            origin = origin + turn @ ca.DM(np.array(arm.links[i]))
            turn = turn @ axis_rotation(np.array(arm.axes[i]), angles[i])
            joints.append((turn, origin))
        return [
            joints[parent][1] + joints[parent][0] @ ca.DM(np.array(offset))
            for parent, offset in zip(arm.point_parents, arm.point_offsets, strict=True)
        ]


def rotation(attitude: ca.SX) -> ca.SX:
    """R = Rz(ψ) Ry(θ) Rx(φ)."""
    axes = np.eye(3)
    return (
        axis_rotation(axes[2], attitude[2]) @ axis_rotation(axes[1], attitude[1]) @ axis_rotation(axes[0], attitude[0])
    )


def axis_rotation(axis: np.ndarray, angle: ca.SX) -> ca.SX:
    """Rodrigues' formula."""
    cross = ca.DM([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return ca.SX.eye(3) + ca.sin(angle) * cross + (1 - ca.cos(angle)) * (cross @ cross)
