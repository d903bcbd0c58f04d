"""The door problem in CasADi, written from the equations in docs and paper: no kernel of doorman's is called."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from suite.task import GRAVITY, Task


def step_function(task: Task) -> Any:
    """F(x, u): one RK4 step of the quasi-static model."""
    x, u, h = ca.SX.sym("x", task.nx), ca.SX.sym("u", task.nu), task.time_step
    k1 = _rates(task, x, u)
    k2 = _rates(task, x + h / 2 * k1, u)
    k3 = _rates(task, x + h / 2 * k2, u)
    k4 = _rates(task, x + h * k3, u)
    return ca.Function("F", [x, u], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)], ["x", "u"], ["next"])


def constraint_function(task: Task) -> Any:
    """h(x) + margin and the tilt's row if it is limited, allowed where they are not positive."""
    x = ca.SX.sym("x", task.nx)
    tilt = [task.least_cosine - ca.cos(x[0]) * ca.cos(x[1])] if task.least_cosine > -1.0 else []
    return ca.Function("h", [x], [ca.vertcat(_constraints(task, x) + task.margin, *tilt)], ["x"], ["h"])


def stage_cost_function(task: Task) -> Any:
    """½ Δt (‖x − x_d‖²_L + ‖u − u_d‖²_R)."""
    x, u = ca.SX.sym("x", task.nx), ca.SX.sym("u", task.nu)
    dx, du = x - ca.DM(task.goal_state), u - ca.DM(task.hover_input)
    cost = ca.dot(ca.DM(task.state_weights) * dx, dx) + ca.dot(ca.DM(task.input_weights) * du, du)
    return ca.Function("l", [x, u], [0.5 * task.time_step * cost], ["x", "u"], ["cost"])


def terminal_cost_function(task: Task) -> Any:
    """½ ‖x − x_d‖²_Q."""
    x = ca.SX.sym("x", task.nx)
    dx = x - ca.DM(task.goal_state)
    return ca.Function("lN", [x], [0.5 * ca.dot(ca.DM(task.terminal_weights) * dx, dx)], ["x"], ["cost"])


def _rates(task: Task, x: ca.SX, u: ca.SX) -> ca.SX:
    roll, pitch, angle, rate = x[0], x[1], x[3], x[4]
    euler = ca.vertcat(
        u[1] + ca.tan(pitch) * (ca.sin(roll) * u[2] + ca.cos(roll) * u[3]),
        ca.cos(roll) * u[2] - ca.sin(roll) * u[3],
        (ca.sin(roll) * u[2] + ca.cos(roll) * u[3]) / ca.cos(pitch),
    )
    normal = ca.vertcat(ca.sin(angle), -ca.cos(angle), 0)
    force = u[0] * _rotation(x)[:, 2] - ca.vertcat(0, 0, task.mass * GRAVITY)
    torque = task.damping * rate + task.stiffness * (angle - task.rest_angle)
    if task.friction > 0.0:
        torque += task.friction * ca.tanh(rate / task.friction_rate)
    acceleration = -(task.distance_from_hinge * ca.dot(normal, force) + torque) / task.door_inertia
    return ca.vertcat(euler, rate, acceleration, u[4:])


def _constraints(task: Task, x: ca.SX) -> ca.SX:
    """Points of the arm below the body, rotor disc clear of the leaf's plane, rotor disc between the jambs."""
    points = _points(task, x[5:])
    attitude, angle, tip = _rotation(x), x[3], points[-1]
    normal = attitude.T @ ca.vertcat(ca.sin(angle), -ca.cos(angle), 0)
    disc = task.radius * ca.sqrt(normal[0] ** 2 + normal[1] ** 2) - ca.dot(normal, tip)
    across, side = attitude[1, :] @ tip, task.distance_from_hinge * ca.sin(angle)
    heights = [point[2] for point in points]
    return ca.vertcat(*heights, disc, side - task.door_width + task.radius - across, across - side + task.radius)


def _points(task: Task, angles: ca.SX) -> list[ca.SX]:
    """Constrained points of the arm in the body frame."""
    turn, origin, joints = ca.SX.eye(3), ca.SX.zeros(3), []
    for i in range(len(task.axes)):
        origin = origin + turn @ ca.DM(task.links[i])
        turn = turn @ _axis_rotation(task.axes[i], angles[i])
        joints.append((turn, origin))
    carriers = [joints[parent] for parent in task.point_parents]
    return [origin + turn @ ca.DM(offset) for (turn, origin), offset in zip(carriers, task.point_offsets, strict=True)]


def _rotation(x: ca.SX) -> ca.SX:
    """R = Rz(ψ) Ry(θ) Rx(φ)."""
    about_x, about_y, about_z = (_axis_rotation(axis, x[i]) for i, axis in enumerate(np.eye(3)))
    return about_z @ about_y @ about_x


def _axis_rotation(axis: np.ndarray, angle: ca.SX) -> ca.SX:
    """Rodrigues' formula."""
    cross = ca.sparsify(ca.DM([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]]))
    return ca.SX.eye(3) + ca.sin(angle) * cross + (1 - ca.cos(angle)) * (cross @ cross)
