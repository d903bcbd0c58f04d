"""The quasi-static door task in numbers: its step and its collision constraints, by kernels printed from the symbols."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import doorman.collision
import doorman.dynamics
import doorman.kinematics
from doorman.arrays import Array
from doorman.collision.rows.listed import IN_A_DOORWAY, Kinds, row_names
from doorman.copying import PerThread
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.printed.loading import load
from doorman.ocp.kernels.printed.printed_problem import kept_text

_MAKERS = doorman.kinematics, doorman.dynamics, doorman.collision
"""Packages whose code makes the text."""


def _printed(pattern: ArmPattern, point_names: tuple[str, ...], numbers: Numbers, kinds: Kinds) -> str:
    """Module of the dynamics and the collision constraints."""
    from doorman.collision.constraints import collision_constraints  # CasADi: only where the text is not there yet
    from doorman.dynamics.quasi_static import QuasiStaticTask

    task = QuasiStaticTask(pattern, point_names, numbers)
    return task.symbolic_model().text(collision_constraints(task, kinds=kinds))


class ReducedModel:
    """x⁺ and h of reduced states x = [Φ, α, α̇, H] and inputs u = [f_t, Ω, Ḣ_d]. Threads may share it."""

    def __init__(self, vehicle: Vehicle, numbers: Numbers, time_step: float, kinds: Kinds = IN_A_DOORWAY) -> None:
        pattern, _ = ArmPattern.of(vehicle.arm)
        key = f"reduced {kinds} {pattern} {vehicle.point_names} {numbers.sizes}"
        self._text = kept_text(key, lambda: _printed(pattern, vehicle.point_names, numbers, kinds), _MAKERS)
        self.numbers, self.time_step = numbers, float(time_step)
        self.nx = 5 + vehicle.n_arm
        self.row_names = row_names(kinds, vehicle.point_names, vehicle.arm.above)
        self.n_rows = len(self.row_names)
        self._own: PerThread[Any] = PerThread()

    def with_numbers(self, changes: Mapping[str, ArrayLike]) -> ReducedModel:
        """Model of the same task with other numbers."""
        changed = object.__new__(ReducedModel)
        vars(changed).update(vars(self))
        changed.numbers, changed._own = self.numbers.replaced(changes), PerThread()
        return changed

    @property
    def _kernels(self) -> Any:
        """This thread's model for kernels, with memory of its own."""
        numbers = self.numbers.vector
        return self._own.get(lambda: load(self._text).Model.of(self.time_step, numbers.copy(), np.zeros((1, 0))))

    def constraints(self, state: Array) -> Array:
        """Values h(x) of the collision constraints; h ≤ 0 is allowed."""
        h = np.empty(self.n_rows)
        functions.constrain(self._kernels, state, h)
        return h

    def constraint_jacobian(self, state: Array) -> Array:
        """Jacobian ∂h/∂x of `constraints`."""
        h, jacobian = np.empty(self.n_rows), np.empty((self.n_rows, self.nx))
        functions.linearize_constraints(self._kernels, state, h, jacobian)
        return jacobian

    def constraints_along(self, states: Array) -> Array:
        """Values of `constraints` at many states."""
        behind = np.concatenate([np.zeros((1, self.nx)), states])  # kernels of a horizon leave its first state out
        h = np.empty((len(states), self.n_rows))
        functions.constrain_horizon(self._kernels, behind, h)
        return h

    def derivative(self, state: Array, inputs: Array) -> Array:
        """Time derivative ẋ."""
        out = np.empty(self.nx)
        load(self._text).rate(self._kernels, state, inputs, out)
        return out

    def step(self, state: Array, inputs: Array) -> Array:
        """State x⁺ after one time step; NaN where the pitch leaves ±90°."""
        out = np.empty(self.nx)
        functions.step(self._kernels, state, inputs, out)
        return out

    def step_jacobian(self, state: Array, inputs: Array) -> Array:
        """Exact sensitivities [A | B] of `step`."""
        jacobian = np.empty((self.nx, self.nx + len(inputs)))
        functions.linearize_step(self._kernels, state, inputs, jacobian)
        return jacobian
