"""The simplified dynamics as a model to plan with: its states and inputs are the reduced ones."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.kinematics.numbers import Numbers
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import GRAVITY, Model
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.solution import PlanStatus
from doorman.planning.composition import NO_EXTRAS, NOTHING, Extras
from doorman.planning.door_problem import door_numbers, door_problem
from doorman.planning.hinge import Hinge
from doorman.planning.limits import largest_push
from doorman.planning.own_motion import stepped

Array = NDArray[np.float64]


_AT_GOAL = 0.05
"""A door within this of the goal need not be moved [rad]."""


class GripPlanning(ABC):
    """What does not depend on the dynamics of a vehicle whose tip holds on to the door; see `PlanningModel`."""

    model: Model
    goal_state: Array

    @abstractmethod
    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        """Reduced states and inputs, see `PlanningModel`.

        Args:
            states: x, shape (nx,) or (m, nx).
            inputs: u at the first of the states, shape (nu,) or (≤ m, nu).

        Returns:
            [Φ, α, α̇, H] of the states and [f_t, Ω, Ḣ_d], and [f_x, f_y] of a fully actuated vehicle, of the inputs.
        """

    def goal(self, start: Array, hinge: Hinge) -> Array:
        """The scenario's goal, leaning against the hinge. See `PlanningModel`.

        Args:
            start: x, shape (nx,).
            hinge: What is known of it.

        Returns:
            x, shape (nx,).
        """
        return leaning(self.model, self.goal_state, hinge)

    def impossible(self, hinge: Hinge, start: Array) -> tuple[PlanStatus, str] | None:
        """Whether the door resists by more than the vehicle can push. See `PlanningModel`.

        Args:
            hinge: What is known of it.
            start: x, shape (nx,).

        Returns:
            `PlanStatus.CANNOT_OPEN`, and its numbers in words; None if nothing speaks against it.
        """
        return too_stiff(self.model, hinge, float(start[3]))

    def normal_forces(self, numbers: Numbers, states: Array, inputs: Array) -> Array:
        """Share of the thrust along the door's normal. See `PlanningModel`.

        Args:
            numbers: What `fitted` returned.
            states: x_0 … x_N, shape (N + 1, nx).
            inputs: u_0 … u_{N−1}, shape (N, nu).

        Returns:
            At every input, shape (N,) [N].
        """
        return push_along_normal(self.model, *self.reduced(states, inputs))


class QuasiStaticPlanning(GripPlanning):
    """x = [Φ, α, α̇, H], u = [f_t, Ω, Ḣ_d]; see `PlanningModel`.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        joints = model.vehicle.joint_names
        self.state_names = ("roll", "pitch", "yaw", "door angle", "door rate", *joints)
        self.input_names = ("thrust", "body rate x", "body rate y", "body rate z", *(f"rate of {j}" for j in joints))
        if model.actuation.fully:
            self.input_names += ("force ahead", "force to the left")
        self.start_state = model.start_state
        self.goal_state = model.goal_state
        self.hover_input = np.concatenate([model.hover_input, np.zeros(2 if model.actuation.fully else 0)])
        self.follows_start = self.has_inertia = False
        self.tolerance = SolverOptions().feasibility
        self.numbers = door_numbers(model)

    def check_state(self, state: ArrayLike, field: str = "state") -> Array:
        """A state as a contiguous float array. See `PlanningModel`.

        Args:
            state: x, shape (nx,).
            field: Name of the argument, for the error.

        Returns:
            Shape (nx,).

        Raises:
            DimensionError: if it has another shape or is not finite.
            SingularityError: if the pitch is not inside ±90°.
        """
        return self.model.check_state(state, field)

    def problem(self, extras: Extras = NO_EXTRAS) -> Problem:
        """The paper's problem. See `PlanningModel`.

        Args:
            extras: Constraints and costs of the user.

        Returns:
            The problem; its parameters are in the order of `numbers`.

        Raises:
            ScenarioError: if a vector of weights does not fit the arm.
            SolverError: if an expression of the user is none.
        """
        return door_problem(self.model, self.numbers, extras)

    def fitted(self, hinge: Hinge, margin: float, start: Array, given: Mapping[str, ArrayLike] = NOTHING) -> Numbers:
        """The scenario's numbers with those of the hinge and the margin; a start changes none. See `PlanningModel`.

        Args:
            hinge: What is known of it.
            margin: Distance from door and frame [m].
            start: x, shape (nx,).
            given: Numbers that replace these.
        """
        known = {**hinge.numbers(), "door.moving_inertia": hinge.inertia, "limits.margin": margin}
        return self.numbers.replaced({**known, **given})

    def state(self, reduced: ArrayLike, body_rates: ArrayLike) -> Array:
        """The reduced state itself: body rates are inputs here. See `PlanningModel`.

        Args:
            reduced: [Φ, α, α̇, H], shape (5 + n,).
            body_rates: Ω, shape (3,), body frame [rad/s].

        Returns:
            x, shape (nx,).
        """
        return np.array(reduced, dtype=np.float64)

    def reduced(self, states: Array, inputs: Array) -> tuple[Array, Array]:
        """States and inputs themselves. See `PlanningModel`.

        Args:
            states: x, shape (nx,) or (m, nx).
            inputs: u at the first of the states, shape (nu,) or (≤ m, nu).

        Returns:
            [Φ, α, α̇, H] of the states and [f_t, Ω, Ḣ_d], and [f_x, f_y] of a fully actuated vehicle, of the inputs.
        """
        return states, inputs

    def force_on_door(self, reduced: Array, rotors: Array, acceleration: Array) -> Array:
        r"""The thrust's, :math:`F_R = f_t R e_3 - m_A g e_3`: the vehicle's own inertia is unknown to this model.

        Args:
            reduced: [Φ, α, α̇, H], shape (5 + n,).
            rotors: Their force, shape (3,), body frame [N].
            acceleration: P̈ of O_B, shape (3,), world frame [m/s²].

        Returns:
            Shape (3,), world frame [N].
        """
        force: Array = rotation_body_to_world(reduced[:3]) @ rotors
        force[2] -= self.model.vehicle.mass * GRAVITY
        return force

    def swing(self, disturbance: float) -> Callable[[Array, Array], Array]:
        r"""This model with the inertia that a push really moves, :math:`I_D + m_A D_V^2`. See `PlanningModel`.

        Args:
            disturbance: Torque in the hinge beyond damping and spring, in the sense of damping [N m].

        Returns:
            x⁺ = f(x, u) over `planner.time_step`.
        """
        model = self.model
        moving = model.door.inertia + model.vehicle.mass * model.coupling.lever_length**2
        known = {"door.moving_inertia": moving, "door.friction": 0.0, "door.disturbance": disturbance}
        if model.actuation.fully:
            return stepped(door_problem(model, self.numbers.replaced(known)))
        return model.reduced.with_numbers(known).step


def push_along_normal(model: Model, states: Array, inputs: Array) -> Array:
    r"""Push of the rotors along the door's normal, :math:`n_D^T (f_t R e_3 - m_A g e_3)`.

    Args:
        model: Model of the scenario.
        states: Reduced, shape (m, 5 + n); a last one without input is left out.
        inputs: Reduced, shape (m or m − 1, 4 + n).

    Returns:
        Shape of the inputs' first axis [N].
    """
    roll, pitch, yaw, angle = states[: len(inputs), :4].T
    door, weight = model.door, model.vehicle.mass * GRAVITY
    normals = door.normals(angle)
    ahead = np.cos(yaw) * normals[:, 0] + np.sin(yaw) * normals[:, 1]
    left = np.cos(yaw) * normals[:, 1] - np.sin(yaw) * normals[:, 0]
    level = np.cos(roll) * np.sin(pitch) * ahead - np.sin(roll) * left
    pushes = inputs[:, 0] * (level + np.cos(roll) * np.cos(pitch) * normals[:, 2]) - weight * normals[:, 2]
    for k, side in enumerate(inputs[:, 4 + model.n_arm :] if model.actuation.fully else ()):
        pushes[k] += normals[k] @ rotation_body_to_world(states[k, :3])[:, : len(side)] @ side
    return np.asarray(pushes)


def resistance(model: Model, hinge: Hinge, angle: float) -> float:
    """Torque of a hinge at rest against the way to the goal [N m].

    Args:
        model: Model of the scenario.
        hinge: What is known of it.
        angle: α [rad].
    """
    torque = hinge.torque_at_rest(angle, model.door.rest_angle) + model.door.weight_torque(angle)
    return hinge.friction + math.copysign(torque, torque * (model.goal_angle - angle))


def too_stiff(model: Model, hinge: Hinge, angle: float) -> tuple[PlanStatus, str] | None:
    """Whether a door resists by more, here or on the way to the goal, than the vehicle can push.

    Args:
        model: Model of the scenario.
        hinge: What is known of it.
        angle: α [rad].

    Returns:
        `PlanStatus.CANNOT_OPEN` and the numbers; None if it can be moved, or is at the goal.
    """
    goal, lever, limits = model.goal_angle, model.coupling.lever_length, model.scenario.limits
    most = model.scenario.control.max_tilt
    if abs(angle - goal) < _AT_GOAL:
        return None
    tilt = min(limits.tilt, most) if limits.enabled else most
    ends = (angle, goal + math.copysign(_AT_GOAL, angle - goal))
    missing = [resistance(model, hinge, end) - lever * largest_push(model, tilt, end) for end in ends]
    if max(missing) <= 0.0:
        return None
    hardest = ends[missing.index(max(missing))]
    worst, push = resistance(model, hinge, hardest), largest_push(model, tilt, hardest)
    words = f"resists by {worst:.2f} N m; {push:.1f} N, {lever:.2f} m from the hinge, make {push * lever:.2f} N m"
    if model.door.slides:
        words = f"resists by {model.door.torque_in_words(worst)}; the vehicle has {push:.2f} N"
    return PlanStatus.CANNOT_OPEN, words


def leaning(model: Model, goal: Array, hinge: Hinge) -> Array:
    """A goal whose attitude pushes against what the door is estimated to resist with, beyond what the scenario names.

    A cost that draws to a level vehicle lets a door creep that needs a steady push.

    Args:
        model: Model of the scenario.
        goal: Begins with Φ and α, shape (nx,).
        hinge: What is known of it.

    Returns:
        The same with the roll and pitch of that push added.
    """
    closer = (hinge.stiffness - model.door.stiffness) * (float(goal[3]) - model.door.rest_angle)
    push = -(hinge.disturbance + closer + model.door.weight_torque(float(goal[3]))) / model.coupling.lever_length
    if model.actuation.fully:
        return goal
    leans = goal.copy()
    leans[:2] += push_state(model, goal, push)[:2]
    return leans


def push_state(model: Model, state: Array, push: float) -> Array:
    r"""A state with the attitude that a push makes by itself, whatever else the rotors hold against.

    A plan knows of the push along n_D and of nothing else: a steady wind that the controller leans into would be taken
    for a force on the tip. So roll and pitch are those of :math:`F_n n_D + m_A g e_3`.

    Args:
        model: Model of the scenario.
        state: Begins with Φ and α, such as the reduced one, x = [Φ, α, α̇, H], shape (nx,).
        push: F_n [N].

    Returns:
        The same with that roll and pitch; the same of a fully actuated vehicle, which stays level.
    """
    if model.actuation.fully:
        return state
    start, yaw, normal = state.copy(), float(state[2]), model.door.normal(float(state[3]))
    forward = push * (math.cos(yaw) * normal[0] + math.sin(yaw) * normal[1])
    left = push * (math.cos(yaw) * normal[1] - math.sin(yaw) * normal[0])
    weight = model.vehicle.mass * GRAVITY + push * normal[2]
    start[0] = math.atan2(-left, math.hypot(forward, weight))
    start[1] = math.atan2(forward, weight)
    return start
