"""Receding-horizon planner: a cold plan once, then warm plans at a fixed number of iterations."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.exceptions import DimensionError
from doorman.model import Model
from doorman.ocp.cddp import Cddp, CddpOptions
from doorman.ocp.door_problem import DoorModel, door_problem
from doorman.ocp.solution import PlanStatus, Solution
from doorman.ocp.warm_start import nearest_shift, shift_rows
from doorman.scenario import Scenario

Array = NDArray[np.float64]

COLD_ITERATIONS = 200
"""Largest number of iterations of a cold plan."""

_RECOVERY_ITERATIONS = 10
"""Largest number of CDDP iterations of the cold plan that replaces a failed replan."""

_LATEST_SHIFT = 2
"""Steps of the previous plan in which the present state is looked for."""


@dataclass(frozen=True)
class Plan:
    """One second or so of motion; arrays are read-only."""

    states: Array
    """x_0 … x_N, shape (N + 1, 5 + n); the first is the state that was given."""
    inputs: Array
    """u_0 … u_{N−1}, shape (N, 4 + n)."""
    cost: float
    """J, the paper's cost."""
    max_violation: float
    """Largest excess of h + margin over 0 at nodes 1 … N [m]."""
    iterations: int
    status: PlanStatus
    solve_time: float
    """Of the whole call [s]."""
    time_step: float
    """Δt between nodes [s]."""

    @property
    def usable(self) -> bool:
        """Whether dynamics and constraints hold along the plan."""
        return self.status.usable


class Planner:
    """Planner of one scenario. The constructor compiles, or loads from the cache; plans never compile.

    Args:
        scenario: The scenario, or a model of it that exists already.
        options: Settings of the solver.

    Raises:
        DoormanError: if the scenario cannot be made a problem.
    """

    def __init__(self, scenario: Scenario | Model, options: CddpOptions | None = None) -> None:
        self.model = scenario if isinstance(scenario, Model) else Model(scenario)
        self.settings = self.model.scenario.planner
        self._problem = door_problem(self.model)
        self._solver = Cddp(self._problem, options)
        self._hover = np.tile(self.model.hover_input, (self._problem.horizon, 1))
        self._metric = self._problem.cost.state_weights.copy()
        self._previous: Solution | None = None
        self._compile()

    def update_door(self, *, friction: float | None = None, disturbance: float | None = None) -> None:
        """Change what the next plans take the hinge to do; the scenario's values hold until the first call.

        Args:
            friction: τ_c [N m].
            disturbance: τ_d of α̈ = … − τ_d/I_D, in the sense of damping: negative where it resists opening [N m].

        Raises:
            DimensionError: if a value is not finite, or the friction is negative.
        """
        model: DoorModel = self._problem.model
        dynamics = model.dynamics
        dynamics = dynamics._replace(
            friction=dynamics.friction if friction is None else float(friction),
            disturbance=dynamics.disturbance if disturbance is None else float(disturbance),
        )
        for name, value in (("friction", dynamics.friction), ("disturbance", dynamics.disturbance)):
            if not np.isfinite(value) or (name == "friction" and value < 0.0):
                raise DimensionError(
                    "not a torque", field=name, given=value, allowed="a finite torque, friction >= 0 [N m]"
                )
        updated = model._replace(dynamics=dynamics)
        self._problem = replace(self._problem, model=updated)
        self._solver.update_model(updated)

    def plan(self, state: ArrayLike) -> Plan:
        """Plan from hover inputs until converged.

        Args:
            state: x = [Φ, α, α̇, H], shape (5 + n,).

        Returns:
            The plan; its status says whether it may be flown.

        Raises:
            DimensionError: if the state has another shape or is not finite.
            SingularityError: if its pitch is not inside ±90°.
        """
        started = time.perf_counter()
        solution = self._cold(self.model.check_state(state))
        return self._keep(solution, started)

    def replan(self, state: ArrayLike, elapsed: float | None = None) -> Plan:
        """Plan from the shifted previous plan, with `planner.iterations` iterations.

        Where there is no previous plan the plan is cold. Where the shifted one cannot be brought inside the constraints, as
        after a jump of the state, a cold plan of a bounded number of iterations takes its place; it may miss the deadline.

        Args:
            state: x = [Φ, α, α̇, H], shape (5 + n,).
            elapsed: Time since the previous plan's state [s]; by default the previous plan is shifted to where it passes
                nearest to `state` within its first two steps.

        Returns:
            The plan; its status says whether it may be flown.

        Raises:
            DimensionError: if the state has another shape, or state or time is not finite.
            SingularityError: if its pitch is not inside ±90°.
        """
        started = time.perf_counter()
        x = self.model.check_state(state)
        if elapsed is not None and not np.isfinite(elapsed):
            raise DimensionError("not a time", field="elapsed", given=elapsed, allowed="a finite time [s]")
        previous = self._previous
        if previous is None:
            return self._keep(self._cold(x), started)
        if elapsed is None:
            shift = nearest_shift(previous.states, x, self._metric, _LATEST_SHIFT)
        else:
            shift = min(max(elapsed / self.settings.time_step, 0.0), float(self._problem.horizon))
        states, inputs, gains = self._shifted
        shift_rows(previous.states, shift, states)
        shift_rows(previous.inputs, shift, inputs)
        shift_rows(previous.gains.reshape(len(inputs), -1), shift, gains.reshape(len(inputs), -1))
        solution = self._solver.solve(
            x, inputs, self.settings.iterations, nominal_states=states, gains=gains, active=previous.multipliers > 0.0
        )
        if not solution.status.usable:  # a jump of the state: start over, rather than hand out the remains
            solution = self._cold(x, _RECOVERY_ITERATIONS)
        return self._keep(solution, started)

    def _cold(self, state: Array, iterations: int = COLD_ITERATIONS) -> Solution:
        return self._solver.solve(state, self._hover, iterations, accelerate=True)

    def _keep(self, solution: Solution, started: float) -> Plan:
        self._previous = solution if solution.status.usable else None
        return Plan(
            states=solution.states,
            inputs=solution.inputs,
            cost=solution.cost,
            max_violation=max(solution.max_violation, 0.0),
            iterations=solution.iterations,
            status=solution.status,
            solve_time=time.perf_counter() - started,
            time_step=self.settings.time_step,
        )

    def _compile(self) -> None:
        """Run the warm-start kernels once, on memory that `replan` then uses."""
        problem = self._problem
        n, nx, nu = problem.horizon, problem.nx, problem.nu
        self._shifted = (np.zeros((n + 1, nx)), np.zeros((n, nu)), np.zeros((n, nu, nx)))
        frozen = self._shifted[0].copy()
        frozen.flags.writeable = False
        nearest_shift(frozen, np.zeros(nx), self._metric, 1)
        shift_rows(frozen, 0.0, self._shifted[0])
