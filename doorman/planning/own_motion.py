"""What planning models share that know the vehicle's own motion: the force that it leaves to the door, and their step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from doorman.gravity import weight_of
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.numba_types.handles import held
from doorman.ocp.kernels import functions
from doorman.ocp.problem.problem import Problem

Array = NDArray[np.float64]


def force_left_to_the_door(mass: float, attitude: Array, rotors: Array, acceleration: Array) -> Array:
    r"""What the vehicle's motion leaves of the thrust, :math:`f_t R e_3 - m_A g e_3 - m_A \ddot P`."""
    force: Array = rotation_body_to_world(attitude) @ rotors - mass * acceleration
    force[2] -= weight_of(mass)
    return force


def rotor_force(inputs: Array, n_arm: int) -> Array:
    """Force of the rotors, of reduced inputs."""
    side = inputs[4 + n_arm :]
    return np.array([*(side if len(side) else (0.0, 0.0)), inputs[0]])


def stepped(problem: Problem) -> Callable[[Array, Array], Array]:
    """The dynamics of a problem, x⁺ = f(x, u)."""
    model = held(problem.model)  # as one pointer: to pass a hundred arrays takes longer than the step

    def step(state: Array, inputs: Array) -> Array:
        following = np.empty_like(state)
        functions.step(model, state, inputs, following)
        return following

    return step
