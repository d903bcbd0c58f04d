"""What planning models share that know the vehicle's own motion: the force that it leaves to the door, and their step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import GRAVITY
from doorman.ocp.kernels import functions
from doorman.ocp.problem.problem import Problem

Array = NDArray[np.float64]


def force_left_to_the_door(mass: float, attitude: Array, thrust: float, acceleration: Array) -> Array:
    r"""What the vehicle's motion leaves of the thrust, :math:`f_t R e_3 - m_A g e_3 - m_A \ddot P`.

    Args:
        mass: m_A [kg].
        attitude: Φ, shape (3,) [rad].
        thrust: f_t [N].
        acceleration: P̈ of O_B, shape (3,), world frame [m/s²].

    Returns:
        Shape (3,), world frame [N].
    """
    force: Array = thrust * rotation_body_to_world(attitude)[:, 2] - mass * acceleration
    force[2] -= mass * GRAVITY
    return force


def stepped(problem: Problem) -> Callable[[Array, Array], Array]:
    """The dynamics of a problem, x⁺ = f(x, u).

    Args:
        problem: Of which the kernels are taken.

    Returns:
        A function of x, shape (nx,), and u, shape (nu,), that returns x⁺, shape (nx,).
    """

    def step(state: Array, inputs: Array) -> Array:
        following = np.empty_like(state)
        functions.step(problem.model, state, inputs, following)
        return following

    return step
