"""What all solvers share: memory, first guess, rollouts with ProxQP where a guess fails, and the solution."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from doorman.checks import number, numbers, vector, whole
from doorman.copying import CopiedWhole
from doorman.exceptions import DimensionError, SolverError
from doorman.numba_types.handles import Handle, held, separate
from doorman.ocp.kernels import functions
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.iterations import augmented_lagrangian, cold_start, guess, rollout
from doorman.ocp.solvers.iterations.careful import iterate_carefully
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.progress import compilation_told
from doorman.ocp.solvers.solution import PlanStatus, Solution, Timings
from doorman.ocp.solvers.sweeps.stage_qp import StageQpSolver
from doorman.ocp.solvers.workspace import RESULT, Multipliers, Workspace

Array = NDArray[np.float64]

StateGuess = Literal["held", "straight"]
STATE_GUESSES: tuple[StateGuess, ...] = ("held", "straight")

DEFAULT_ITERATIONS = 200

FAST_ITERATIONS = 25
"""Largest number of fast iterations from one guess, before another guess or the careful phase has its turn."""


class Solver(CopiedWhole, ABC):
    """A solver of one problem. Its constructor compiles, or loads from the cache on disk; solving never does.

    Not to be shared between threads: it owns its memory. Several solvers of one problem may run in threads of their own. A copy,
    and what is unpickled, goes on from the same guess, multipliers and parameters, in memory of its own.

    Args:
        problem: The problem.
        options: Settings.

    Raises:
        SolverError: if the model has no kernel for `step`, or declares integrators that are none.
    """

    def __init__(self, problem: Problem, options: SolverOptions | None = None) -> None:
        self._problem, self._numbers_are_new = problem, False
        self.options = options or SolverOptions()
        if not functions.is_implemented(functions.step, type(problem.model)):
            raise SolverError(
                "the model's type has no kernel for 'step'", field="problem.model",
                given=type(problem.model).__name__, allowed="a NamedTuple type with implement(functions.step, …)",
            )  # fmt: skip
        self._work = Workspace.of(problem, self.options)
        self._memory = held(self._work)
        self._model = Handle(separate(problem.model))
        self._qp = StageQpSolver(problem.nu, len(self._work.program.constraints))
        self._rollout_time, self._deadline, self._gave_up = 0.0, math.inf, False
        self._given = False, False, False
        """Whether inputs, states and multipliers of the first guess are given."""
        self.quadratic_programs = 0
        """Quadratic programs that ProxQP has solved so far."""
        with compilation_told(problem):
            self._compile()
            self._check_integrators()
        self._forget_failures()

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
        max_iterations: int = DEFAULT_ITERATIONS,
        time_limit: float = math.inf,
    ) -> Solution:
        """Solve from a first guess.

        Args:
            state: First state, shape (nx,).
            inputs: Guess, shape (N, nu); the cost's input goal if not given.
            states: Guess, shape (N + 1, nx), which need not satisfy the dynamics; "held" is the first state at all nodes,
                "straight" the line from there to the goal. If not given, the solver chooses, or rolls given inputs out.
            multipliers: Guess, as of an earlier solution; zero if not given.
            max_iterations: Largest number of iterations; one linearises and sweeps.
            time_limit: No iteration begins that would not be over by then, if it takes as long as the longest so far; then
                ProxQP is not asked any more [s].

        Returns:
            The solution; its status says whether it may be used.

        Raises:
            DimensionError: if an array has the wrong shape or is not finite, or a budget is not positive.
        """
        started = time.monotonic()
        x = vector(state, self._problem.nx, "state")
        status, iterations = self.run(
            x, inputs, states=states, multipliers=multipliers, max_iterations=max_iterations, time_limit=time_limit
        )
        return self._solution(status, iterations, time.monotonic() - started)

    def run(
        self,
        state: Array,
        inputs: ArrayLike | None = None,
        *,
        states: ArrayLike | StateGuess | None = None,
        multipliers: Multipliers | None = None,
        max_iterations: int = DEFAULT_ITERATIONS,
        time_limit: float = math.inf,
    ) -> tuple[PlanStatus, int]:
        """The same from a checked, contiguous state; the result stays in the solver's memory.

        Returns:
            How it ended, and the number of iterations.
        """
        max_iterations = checked_budget(max_iterations, time_limit)
        self._deadline = deadline = time.monotonic() + time_limit
        self._rollout_time, self._gave_up = 0.0, False
        self._forget_failures()
        self._set_guess(state, inputs, states, multipliers)
        status, iterations = self._solve(state, max_iterations, deadline)
        self._raise_failure()
        return self._judged(status), iterations

    def _forget_failures(self) -> None:
        """Forget what functions of the model have raised, if it keeps that: kernels let nothing through."""
        if hasattr(self._model.content, "forget_failures"):
            self._model.content.forget_failures()

    def _raise_failure(self) -> None:
        """Raise what a function of the model has raised meanwhile."""
        if hasattr(self._model.content, "raise_failure"):
            self._model.content.raise_failure()

    @abstractmethod
    def _solve(self, state: Array, max_iterations: int, deadline: float) -> tuple[PlanStatus, int]:
        """Solve from a state and the guess in the workspace: status and number of iterations."""

    def update_model(self, model: Any) -> None:
        """Take other parameters of the same model, without compiling.

        Args:
            model: NamedTuple of the problem's type.

        Raises:
            DimensionError: if it has another type.
        """
        if type(model) is not type(self._model.content):
            raise DimensionError("another type of model", field="model", given=type(model).__name__,
                                 allowed=type(self._model.content).__name__)  # fmt: skip
        self._model.replace(separate(model))

    def update_goal(self, state_goal: ArrayLike) -> None:
        """Take another goal of the quadratic cost.

        Args:
            state_goal: x^g, shape (nx,).

        Raises:
            DimensionError: if it has another shape or is not finite.
        """
        self._work.weights.state_goal[:] = vector(state_goal, self._problem.nx, "state_goal")
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
            model.parameters[:] = vector(parameters, len(model.parameters), "parameters")
        if node_parameters is not None:
            model.node_parameters[:] = per_node(node_parameters, model.node_parameters.shape)
        self._numbers_are_new = True

    def _set_guess(
        self, state: Array, inputs: ArrayLike | None, states: ArrayLike | StateGuess | None,
        multipliers: Multipliers | None,
    ) -> None:  # fmt: skip
        """Put what is given of a first guess into the workspace."""
        work = self._work
        self._given = inputs is not None, states is not None, multipliers is not None
        if inputs is not None:
            _copy_checked("inputs", inputs, work.nominal.inputs)
        if isinstance(states, str):
            self._draw_states(state, states, inputs is None)
        elif states is not None:
            _copy_checked("states", states, work.nominal.states)
        for name in Multipliers._fields if multipliers is not None else ():
            _copy_checked(f"multipliers.{name}", getattr(multipliers, name), getattr(work.multipliers, name))

    def _draw_states(self, state: Array, how: str, goal_inputs: bool) -> None:
        """Nominal states that a word describes, with the input goal where no inputs are given."""
        if how not in STATE_GUESSES:
            raise DimensionError(
                "no such guess", field="states", given=how, allowed="an array, " + ", ".join(STATE_GUESSES)
            )
        nominal = self._work.nominal
        nominal.states[:] = state
        if goal_inputs:
            nominal.inputs[:] = self._work.weights.input_goal
        if how == "straight":
            guess.aim_straight(self._memory)
        self._given = True, True, self._given[2]

    def _begin(self, state: Array) -> bool:
        """Start anew from the guess in the workspace; whether dynamics and constraints are finite there."""
        return bool(cold_start.begin(self._model, self._memory, state, *self._given))

    def _guess_again(self) -> None:
        """Begin again with the first guess."""
        self._forget_multipliers()
        np.copyto(self._work.nominal.states, self._work.first.states)
        np.copyto(self._work.nominal.inputs, self._work.first.inputs)

    def _forget_multipliers(self) -> None:
        for array in self._work.multipliers:
            array[:] = 0.0

    def _iterate_carefully(self, penalty: float, max_iterations: int, deadline: float) -> int:
        """Careful iterations from the nominal trajectory and the multipliers; their code."""
        feasibility = self.options.feasibility
        return int(iterate_carefully(self._model, self._memory, penalty, feasibility, max_iterations, deadline))

    def _roll_out(self, scale: float) -> bool:
        """Rollout into the trial trajectory, ProxQP where a guess fails; False if it is not finite."""
        begun = time.monotonic()
        self._work.trial.states[0] = self._work.nominal.states[0]
        guessing = self.options.guess_active_sets
        code = rollout.roll_out(self._model, self._memory, -1, scale, guessing, 0)
        done = self._resume(code, scale) if code >= 0 else code == rollout.DONE
        self._rollout_time += time.monotonic() - begun
        return bool(done)

    def _resume(self, node: int, scale: float = 0.0) -> bool:
        """Go on with a rollout that stopped at a node whose correction is left to ProxQP; False if it is not finite."""
        code = node
        while code >= 0:
            corrections = int(self._work.result[RESULT.CORRECTIONS]) + 1 if self._solve_program() else -1
            code = rollout.roll_out(self._model, self._memory, code, scale, self.options.guess_active_sets, corrections)
        return bool(code == rollout.DONE)

    def _solve_program(self) -> bool:
        """Leave a node's program to ProxQP; False if that finds no solution, or time is over."""
        if time.monotonic() >= self._deadline:
            self._gave_up = True
            return False
        self.quadratic_programs += 1
        return self._qp.solve(self._work.program)

    def _accept(self) -> None:
        """The trial trajectory becomes the nominal one."""
        guess.accept_trial(self._memory)

    def _last_violated(self) -> int:
        return int(guess.last_violation(self._memory, self.options.feasibility))

    def _judged(self, status: PlanStatus) -> PlanStatus:
        """A status that agrees with what was measured last, of the nominal trajectory."""
        result, feasibility = self._work.result, self.options.feasibility
        if not status.usable:
            return status
        if not math.isfinite(result[RESULT.INFEASIBILITY]):
            return PlanStatus.DIVERGED
        if result[RESULT.DEFECT] > feasibility:
            return PlanStatus.INFEASIBLE
        if result[RESULT.VIOLATION] > feasibility:
            returns = not self._gave_up and self._last_violated() < self._problem.horizon
            return PlanStatus.RECOVERING if returns and self._inputs_within() else PlanStatus.INFEASIBLE
        return status

    def _inputs_within(self) -> bool:
        """Whether the nominal trajectory's inputs keep to their bounds."""
        inputs, limits, slack = self._work.nominal.inputs, self._work.limits, self.options.feasibility
        within = (inputs >= limits.input_lower - slack) & (inputs <= limits.input_upper + slack)
        return bool(within.all())

    def _solution(self, status: PlanStatus, iterations: int, total: float) -> Solution:
        """Solution of the nominal trajectory, which was measured last."""
        work, result = self._work, self._work.result
        finite = math.isfinite(result[RESULT.INFEASIBILITY])
        return Solution(
            problem=self.problem,
            states=read_only(work.nominal.states),
            inputs=read_only(work.nominal.inputs),
            gains=read_only(work.policy.gains[:, :, : self._problem.nx]),
            multipliers=Multipliers(*(read_only(array) for array in work.multipliers)),
            cost=float(result[RESULT.COST]) if status.flyable else math.inf,
            violation=float(result[RESULT.VIOLATION]) if finite else math.inf,
            violation_node=int(result[RESULT.NODE]),
            violation_row=int(result[RESULT.ROW]),
            recovered_at=(self._last_violated() if finite else self._problem.horizon) + 1,
            defect=float(result[RESULT.DEFECT]),
            iterations=iterations,
            status=status,
            timings=Timings(total, total - self._rollout_time, self._rollout_time),
        )

    def _compile(self) -> None:
        """Run every kernel once."""
        goal = self._problem.cost.state_goal.copy()
        self._set_guess(goal, None, None, None)
        self._begin(goal)
        guess.aim_straight(self._memory)
        guess.last_violation(self._memory, 0.0)
        augmented_lagrangian.linearize(self._model, self._memory)
        augmented_lagrangian.measure_nominal(self._memory)
        augmented_lagrangian.nominal_cost(self._model, self._memory)
        self._roll_out(0.0)
        self._accept()

    def _check_integrators(self) -> None:
        """Compare the rows that the problem calls integrators with the model's Jacobian."""
        m, nx, nu = self._problem.integrators, self._problem.nx, self._problem.nu
        if m == 0:
            return
        jacobian, expected = np.zeros((nx, nx + nu)), np.zeros((m, nx + nu))
        goal = self._problem.cost
        functions.linearize_step(
            functions.at_node(self._model, 0), goal.state_goal.copy(), goal.input_goal.copy(), jacobian
        )
        expected[:, nx - m : nx] = np.eye(m)
        expected[:, nx + nu - m :] = self._problem.time_step * np.eye(m)
        others = jacobian[: nx - m, [*range(nx - m, nx), *range(nx + nu - m, nx + nu)]]
        if not np.allclose(jacobian[nx - m :], expected, atol=1e-7) or np.abs(others).max(initial=0.0) > 1e-7:
            raise SolverError(
                "the last states are not integrators of the last inputs", field="problem.integrators", given=m,
                allowed="x⁺ = x + Δt u, and no other state depends on them",
            )  # fmt: skip


def checked_budget(max_iterations: int, time_limit: float) -> int:
    """Number of iterations as kernels take it.

    Raises:
        DimensionError: if it is no integer, or a budget is not positive.
    """
    if time_limit != math.inf and number(time_limit, "time_limit", "> 0 s") <= 0.0:
        raise DimensionError("no time", field="time_limit", given=time_limit, allowed="> 0 s")
    return whole(max_iterations, "max_iterations", 1)


def per_node(values: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Numbers for every node, checked.

    Args:
        values: Shape (N + 1, nq), or (nq,) for the same at all nodes.
        shape: (N + 1, nq).

    Returns:
        Shape (N + 1, nq), not to be written to.

    Raises:
        DimensionError: if the shape is another, or a number is not finite.
    """
    given = np.asarray(values, dtype=np.float64)
    if given.shape not in (shape, shape[1:]) or not np.isfinite(given).all():
        raise DimensionError(
            "not parameters of the nodes", field="node_parameters", given=given.shape,
            allowed=f"finite numbers of shape {shape} or {shape[1:]}",
        )  # fmt: skip
    return np.broadcast_to(given, shape)


def _copy_checked(field: str, values: ArrayLike, out: Array) -> None:
    given = numbers(values, field)
    if given.shape != out.shape:
        raise DimensionError("wrong shape", field=field, given=given.shape, allowed=str(out.shape))
    if not np.isfinite(given).all():
        raise DimensionError("not finite", field=field, allowed="finite numbers")
    out[:] = given


def read_only(array: Array) -> Array:
    """A copy that cannot be written to."""
    copy = array.copy()
    copy.setflags(write=False)
    return copy
