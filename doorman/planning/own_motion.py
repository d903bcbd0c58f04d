"""What planning models share: the rotors' force in reduced inputs, and the step of a problem."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.numba_types.handles import held, separate
from doorman.ocp.kernels import functions
from doorman.ocp.problem.problem import Problem


def rotor_force(inputs: Array, n_arm: int) -> Array:
    """Force of the rotors, of reduced inputs."""
    side = inputs[4 + n_arm :]
    return np.array([*(side if len(side) else (0.0, 0.0)), inputs[0]])


class Motion:
    """The dynamics of a problem, x⁺ = f(x, u), with numbers of its own."""

    def __init__(self, problem: Problem) -> None:
        self._model = separate(problem.model)
        self._held = held(self._model)  # as one pointer: to pass a hundred arrays takes longer than the step
        self._first = problem.hidden_parameters

    def know(self, numbers: Array) -> None:
        """Take other numbers of a symbolic model."""
        self._model.parameters[self._first :] = numbers

    def __call__(self, state: Array, inputs: Array) -> Array:
        """One step."""
        following = np.empty_like(state)
        functions.step(self._held, state, inputs, following)
        return following
