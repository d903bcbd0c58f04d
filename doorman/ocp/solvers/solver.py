"""A solver as everybody calls it: solve, many at once, other numbers of the same problem, and the solution."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from doorman.arrays import Array, frozen
from doorman.checks import number, per_node, vector
from doorman.exceptions import DimensionError, SolverError
from doorman.numba_types.handles import separate
from doorman.ocp.problem.problem import FIRST_GOAL, Problem
from doorman.ocp.solvers.arguments import checked_budget, checked_state
from doorman.ocp.solvers.batch import solve_all
from doorman.ocp.solvers.engine import Engine, StateGuess
from doorman.ocp.solvers.iterations.augmented_lagrangian import ACCURACY
from doorman.ocp.solvers.iterations.real_time import STEER, settle
from doorman.ocp.solvers.kept import Kept
from doorman.ocp.solvers.memory.parts import Multipliers
from doorman.ocp.solvers.solution import PlanStatus, Solution, Timings
from doorman.ocp.solvers.stretch import time_step_of
from doorman.ocp.solvers.telling import Callback, Stopped

DEFAULT_ITERATIONS = 200


class Solver(Engine):
    """A solver of one problem. Its constructor compiles, or loads from the cache on disk; solving never does.

    Not to be shared between threads: it owns its memory. Several solvers of one problem may run in threads of their own. A copy,
    and what is unpickled, goes on from the same guess, multipliers and parameters, in memory of its own.

    Args:
        problem: The problem.
        options: Settings.

    Raises:
        SolverError: if the model has no kernel for `step`, or declares integrators that are none.
    """

    @property
    def problem(self) -> Problem:
        """The problem with its present goal and parameters."""
        if self._numbers_are_new:
            cost, model = replace(self._problem.cost, state_goal=self._work.weights.state_goal), self._model.content
            self._problem, self._numbers_are_new = replace(self._problem, cost=cost, model=separate(model)), False
        return self._problem

    def solve(
        self,
        state: ArrayLike,
        inputs: ArrayLike | None = None,
        *,
        states: ArrayLike | StateGuess | None = None,
        multipliers: Multipliers | None = None,
        warm_start: Solution | None = None,
        max_iterations: int = DEFAULT_ITERATIONS,
        time_limit: float = math.inf,
        callback: Callback | None = None,
        time_step: float | None = None,
    ) -> Solution:
        """Solve from a first guess.

        Args:
            state: First state, shape (nx,).
            inputs: Guess, shape (N, nu); the cost's input goal if not given.
            states: Guess, shape (N + 1, nx), which need not satisfy the dynamics; "held" is the first state at all nodes,
                "straight" the line from there to the goal. If not given, the solver chooses, or rolls given inputs out.
            multipliers: Guess, as of an earlier solution; zero if not given.
            warm_start: An earlier solution, perhaps of another process: its inputs, states and multipliers are the guess.
            max_iterations: Largest number of iterations; one linearises and sweeps.
            time_limit: No iteration begins that would not be over by then, if it takes as long as the longest so far; then
                ProxQP is not called any more [s].
            callback: Gets every iteration as an `Iterate`; where it returns something true, the solve ends with what there is.
                A solve with one takes its kernels iteration by iteration. What it raises comes out of this.
            time_step: Guess of a free time's step; the problem's if not given [s].

        Returns:
            The solution; its status says whether it may be used.

        Raises:
            DimensionError: if an array has the wrong shape or is not finite, a budget is not positive, a guess is given
                twice, or a time step where the time is not free.
        """
        started = time.monotonic()
        x = checked_state(state, self._problem)
        if time_step is not None and (self._problem.free_time is None or not number(time_step, "time_step") > 0.0):
            raise DimensionError("no guess of a free time", field="time_step", given=time_step,
                                 allowed="> 0 s, of a problem with free_time")  # fmt: skip
        if warm_start is not None:
            if not (inputs is None and states is None and multipliers is None):
                raise DimensionError("a guess is given twice", field="warm_start",
                                     allowed="either warm_start, or inputs, states, multipliers")  # fmt: skip
            inputs, states, multipliers = warm_start.inputs, warm_start.states, warm_start.multipliers
            time_step = warm_start.time_step
        self._teller.callback = callback
        try:
            status, iterations = self.run(
                x, inputs, states=states, multipliers=multipliers, max_iterations=max_iterations, time_limit=time_limit,
                time_step=time_step,
            )  # fmt: skip
        finally:
            self._teller.callback = None
        return self._solution(status, iterations, time.monotonic() - started)

    def solve_batch(
        self,
        states: Sequence[ArrayLike] | Array,
        *,
        threads: int | None = None,
        warm_starts: Sequence[Solution] | None = None,
        **options: Any,
    ) -> list[Solution | Exception]:
        """Solve from many first states on many threads, without the interpreter's lock.

        Every thread has a copy of this solver. A result has the bits of a solve in a fresh solver, whatever the number of
        threads; only a `time_limit` makes a difference.

        Args:
            states: First states, each of shape (nx,).
            threads: How many; as many as there are processors if not given.
            warm_starts: An earlier solution for each of them.
            options: Of `solve`, for all of them.

        Returns:
            Solutions in the order of the states. Where a function of the model has raised something, its exception is there
            instead; the others are not lost.

        Raises:
            DimensionError: if states have another shape or are not finite, or there are more or fewer warm starts than states.
        """
        size = self._problem.given_states
        starts = [vector(state, size, f"states[{i}]") for i, state in enumerate(states)]
        warm = [None] * len(starts) if warm_starts is None else list(warm_starts)
        if len(warm) != len(starts):
            raise DimensionError("wrong number", field="warm_starts", given=len(warm), allowed=str(len(starts)))
        return solve_all(
            self, list(zip(starts, warm, strict=True)),
            lambda worker, state, warm: worker.solve(state, warm_start=warm, **options), threads,
        )  # fmt: skip

    def run(
        self,
        state: Array,
        inputs: ArrayLike | None = None,
        *,
        states: ArrayLike | StateGuess | None = None,
        multipliers: Multipliers | None = None,
        max_iterations: int = DEFAULT_ITERATIONS,
        time_limit: float = math.inf,
        time_step: float | None = None,
    ) -> tuple[PlanStatus, int]:
        """Solve from a checked, contiguous state, and leave the result in the solver's memory. See `solve`.

        Args:
            state: x_0, shape (nx,).
            inputs: First guess of U, shape (N, nu).
            states: First guess of X, shape (N + 1, nx), or a way to make one.
            multipliers: First guess of the multipliers.
            max_iterations: Budget of iterations.
            time_limit: Budget of time [s].
            time_step: First guess of a free time's step [s].

        Returns:
            How it ended, and the number of iterations.
        """
        max_iterations = checked_budget(max_iterations, time_limit)
        self._deadline = deadline = time.monotonic() + time_limit
        self._rollout_time, self._gave_up = 0.0, False
        self._work.result.guess, self._seen = math.nan, None
        self._forget_failures()
        self._set_guess(state, inputs, states, multipliers, time_step)
        self._prices = None if multipliers is None else Multipliers(*(array.copy() for array in self._work.multipliers))
        try:
            status, iterations = self._solve(state, max_iterations, deadline)
        except Stopped:
            iterations = self._work.result.iterations
            status = PlanStatus.ITERATION_LIMIT if self._start() else PlanStatus.DIVERGED
        self._raise_failure()
        return self._best(self._judged(status)), iterations

    def update_model(self, model: Any) -> None:
        """Take other parameters of the same model, without compiling.

        Args:
            model: NamedTuple of the problem's type.

        Raises:
            DimensionError: if it has another type.
        """
        if type(model) is not type(self._model.content):
            raise DimensionError("wrong type of model", field="model", given=type(model).__name__,
                                 allowed=type(self._model.content).__name__)  # fmt: skip
        self._model.replace(separate(model))

    def update_goal(self, state_goal: ArrayLike) -> None:
        """Take another goal of the quadratic cost.

        Args:
            state_goal: x^g, shape (nx,).

        Raises:
            DimensionError: if it has another shape or is not finite.
        """
        size = self._problem.given_states
        goal = vector(state_goal, size, "state_goal")
        self._work.weights.state_goal[:size] = goal
        if self._problem.free_time is not None:
            self._model.content.parameters[FIRST_GOAL : FIRST_GOAL + size] = goal
        self._numbers_are_new = True

    def update_parameters(self, parameters: ArrayLike | None = None, node_parameters: ArrayLike | None = None) -> None:
        """Take other numbers for a symbolic model's parameters, without compiling.

        Args:
            parameters: Of the problem, shape (np,); the present ones stay if not given.
            node_parameters: Of nodes 0 … N, shape (N + 1, nq), or (nq,) for the same at all; the present ones stay if not
                given.

        Raises:
            SolverError: if the model has no parameters.
            DimensionError: if a shape is another, or a number is not finite.
        """
        model = self._model.content
        if not hasattr(model, "node_parameters"):
            raise SolverError(
                "this model has no parameters", field="problem.model", given=type(model).__name__,
                allowed="a problem of a SymbolicModel; update_model takes others",
            )  # fmt: skip
        if parameters is not None:
            own = model.parameters[self._problem.hidden_parameters :]
            own[:] = vector(parameters, len(own), "parameters")
        if node_parameters is not None:
            of_node = model.node_parameters[:, : model.node_parameters.shape[1] - (self._problem.free_time is not None)]
            of_node[:] = per_node(node_parameters, of_node.shape)
        self._numbers_are_new = True

    def _solution(self, status: PlanStatus, iterations: int, total: float) -> Solution:
        """Solution of the nominal trajectory, which was measured last."""
        work, result, nx, nu = self._work, self._work.result, self._problem.given_states, self._problem.given_inputs
        finite = math.isfinite(result.infeasibility)
        return Solution(
            problem=self.problem,
            states=frozen(work.nominal.states[:, :nx]),
            inputs=frozen(work.nominal.inputs[:, :nu]),
            time_step=time_step_of(self._problem, work.nominal.inputs),
            gains=frozen(work.policy.gains[:, :nu, :nx]),
            multipliers=Multipliers(*(frozen(array) for array in work.multipliers)),
            cost=result.cost if status.flyable else math.inf,
            violation=result.violation if finite else math.inf,
            violation_node=result.node,
            violation_row=result.row,
            recovered_at=(self._last_violated() if finite else self._problem.horizon) + 1,
            defect=result.defect,
            iterations=iterations,
            status=status,
            timings=Timings(total, total - self._rollout_time, self._rollout_time),
        )

    def _judged(self, status: PlanStatus) -> PlanStatus:
        """A status that agrees with what was measured last, of the nominal trajectory."""
        result, feasibility = self._work.result, self.options.feasibility
        if not status.usable:
            return status
        if not math.isfinite(result.infeasibility):
            return PlanStatus.DIVERGED
        if result.defect > feasibility:
            return PlanStatus.INFEASIBLE
        if result.violation > feasibility:
            returns = not self._gave_up and self._last_violated() < self._problem.horizon
            return PlanStatus.RECOVERING if returns and self._inputs_within() else PlanStatus.INFEASIBLE
        return status

    def _best(self, status: PlanStatus) -> PlanStatus:
        """Status of the best feasible trajectory that was seen, the guess included, which is the nominal one from then on."""
        result, work = self._work.result, self._work
        found = result.cost if status.usable else math.inf
        seen, self._seen = self._seen, None
        others = [seen] if seen is not None else []
        if result.guess < found:
            others.append(Kept.guess_of(work, self._prices))
        least = min((other.cost + ACCURACY * (1.0 + abs(other.cost)) for other in others), default=math.inf)
        if not least < found or status is PlanStatus.INVALID_STATE:
            return status
        own, price = Kept.of(work, result.cost), result.costate
        price = max(price, own.dearest) if status.usable else 0.0
        for other in sorted(others, key=lambda kept: kept.cost):
            self._put_back_whole(other)
            worth = other.cost + ACCURACY * (1.0 + abs(other.cost)) + price * result.infeasibility
            if self._feasible() and worth < found:
                if other is not seen:  # the guess itself has no feedback
                    settle(self._model, self._memory, STEER)
                return PlanStatus.ITERATION_LIMIT
        self._put_back_whole(own)
        return status

    def _inputs_within(self) -> bool:
        """Whether the nominal trajectory's inputs keep to their bounds."""
        inputs, limits, slack = self._work.nominal.inputs, self._work.limits, self.options.feasibility
        within = (inputs >= limits.input_lower - slack) & (inputs <= limits.input_upper + slack)
        return bool(within.all())
