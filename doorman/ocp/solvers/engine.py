"""What all solvers stand on: memory, first guess, kernels that are compiled, and rollouts with ProxQP where a guess fails."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.copying import CopiedWhole
from doorman.exceptions import DimensionError, SolverError
from doorman.numba_types.handles import held, separate
from doorman.ocp.kernels import functions
from doorman.ocp.kernels.compiled_model import table_of
from doorman.ocp.problem.problem import Problem
from doorman.ocp.solvers.arguments import copy_checked
from doorman.ocp.solvers.iterations import cold_start, guess, nominal, rollout
from doorman.ocp.solvers.iterations.real_time import STEER, settle
from doorman.ocp.solvers.kept import Kept
from doorman.ocp.solvers.memory.parts import Multipliers
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.progress import compilation_told
from doorman.ocp.solvers.solution import PlanStatus
from doorman.ocp.solvers.stretch import set_stretch
from doorman.ocp.solvers.sweeps.stage_qp import StageQpSolver
from doorman.ocp.solvers.telling import Teller

StateGuess = Literal["held", "straight"]
STATE_GUESSES: tuple[StateGuess, ...] = ("held", "straight")

FAST_ITERATIONS = 25
"""Largest number of fast iterations from one guess, before something else has its turn."""


class Given(NamedTuple):
    """What of the first guess is given."""

    inputs: bool
    states: bool
    multipliers: bool


class Engine(CopiedWhole, ABC):
    """Memory and moves of one problem's solver; what they add up to is a `Solver`."""

    def __init__(self, problem: Problem, options: SolverOptions | None = None) -> None:
        self._problem, self._numbers_are_new = problem, False
        self.options = options or SolverOptions()
        if not functions.is_implemented(functions.step, type(problem.model)):
            raise SolverError(
                "the model's type has no kernel for 'step'", field="problem.model",
                given=type(problem.model).__name__, allowed="a NamedTuple type with implement(functions.step, …)",
            )  # fmt: skip
        self._rollout_time, self._deadline, self._gave_up = 0.0, math.inf, False
        self._prices: Multipliers | None = None
        """Multipliers of the first guess, where they are given."""
        self._seen: Kept | None = None
        """The best feasible trajectory of the present solve that it has left behind."""
        self._given = Given(False, False, False)
        self.quadratic_programs = 0
        """Quadratic programs that ProxQP has solved so far."""
        with compilation_told(problem):
            self._work = Workspace.of(problem, self.options)
            self._teller = Teller(self._work.result)
            self._memory = held(self._work)
            self._qp = StageQpSolver(problem.nu, len(self._work.program.constraints))
            self._model: Any = table_of(separate(problem.model), problem, self._is_curved)
            self._compile()
            self._check_integrators()
        self._forget_failures()

    @property
    def _is_curved(self) -> bool:
        """Whether the solver asks for second derivatives of the model."""
        return False

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

    def _set_guess(
        self, state: Array, inputs: ArrayLike | None, states: ArrayLike | StateGuess | None,
        multipliers: Multipliers | None, time_step: float | None = None,
    ) -> None:  # fmt: skip
        """Put what is given of a first guess into the workspace."""
        work, problem = self._work, self._problem
        self._given = Given(inputs is not None, states is not None, multipliers is not None)
        if inputs is not None:
            copy_checked("inputs", inputs, work.nominal.inputs[:, : problem.given_inputs])
        if isinstance(states, str):
            self._draw_states(state, states, inputs is None)
        elif states is not None:
            copy_checked("states", states, work.nominal.states[:, : problem.given_states])
        if problem.free_time is not None:
            set_stretch(work.nominal, 1.0 if time_step is None else time_step / problem.time_step)
        for name in Multipliers._fields if multipliers is not None else ():
            copy_checked(f"multipliers.{name}", getattr(multipliers, name), getattr(work.multipliers, name))

    def _draw_states(self, state: Array, how: str, goal_inputs: bool) -> None:
        """Nominal states that a word describes, with the input goal where no inputs are given."""
        if how not in STATE_GUESSES:
            raise DimensionError(
                "unknown guess", field="states", given=how, allowed="an array, " + ", ".join(STATE_GUESSES)
            )
        nominal = self._work.nominal
        nominal.states[:] = state
        if goal_inputs:
            nominal.inputs[:] = self._work.weights.input_goal
        if how == "straight":
            guess.aim_straight(self._memory)
        self._given = Given(True, True, self._given.multipliers)

    def forget(self) -> None:
        """Forget active sets of earlier solves: the next one has the bits that it would have in a fresh solver."""
        for array in (*self._work.active, self._work.program.active, self._work.program.proposal):
            array[:] = 0
        self._qp = StageQpSolver(self._problem.nu, len(self._work.program.constraints))

    def stop(self) -> None:
        """End the solve that runs in another thread with what there is; no later one gets far."""
        self._teller.stop()
        self._deadline = 0.0

    def _begin(self, state: Array) -> bool:
        """Start anew from the guess in the workspace; whether dynamics and constraints are finite there."""
        return bool(cold_start.begin(self._model, self._memory, state, *self._given))

    def _forget_multipliers(self) -> None:
        for array in self._work.multipliers:
            array[:] = 0.0

    def _start(self) -> bool:
        """Roll the nominal trajectory out; False if that is not finite."""
        return self._take(self._roll_out(0.0))

    def _take(self, finite: bool) -> bool:
        """Take a rollout for the nominal trajectory, unless it is not finite."""
        if finite:
            self._accept()
        else:
            self._measure()
        return finite

    def _roll_out(self, scale: float) -> bool:
        """Rollout into the trial trajectory, ProxQP where a guess fails; False if it is not finite."""
        begun = time.monotonic()
        self._work.trial.states[0] = self._work.nominal.states[0]
        code = rollout.roll_out(self._model, self._memory, -1, scale, 0)
        done = self._resume(code, scale) if code >= 0 else code == rollout.DONE
        self._rollout_time += time.monotonic() - begun
        return bool(done)

    def _resume(self, node: int, scale: float = 0.0) -> bool:
        """Go on with a rollout that stopped at a node whose correction is left to ProxQP; False if it is not finite."""
        code = node
        while code >= 0:  # a node has a few corrections, and none is left by the horizon's end
            corrections = self._work.result.corrections + 1 if self._solve_program() else -1
            code = rollout.roll_out(self._model, self._memory, code, scale, corrections)
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
        for source, target in zip(self._work.trial, self._work.nominal, strict=True):
            np.copyto(target, source)

    def _measure(self) -> None:
        """Derivatives, defects and violations of the nominal trajectory."""
        nominal.linearize(self._model, self._memory)
        nominal.measure_nominal(self._memory)

    def _put_back_whole(self, kept: Kept) -> None:
        """Make what was kept the nominal trajectory with its feedback, measured."""
        kept.put_back(self._work)
        self._measure()
        self._work.result.cost = kept.cost

    def _feasible(self) -> bool:
        """Whether dynamics, rows and bounds hold along the trajectory that was measured last."""
        result = self._work.result
        return bool(max(result.violation, result.defect) <= self.options.feasibility)

    def _remember(self) -> None:
        """Keep the nominal trajectory, measured, if it is the best feasible one so far."""
        cost = self._work.result.cost
        if self._feasible() and (self._seen is None or cost < self._seen.cost):
            self._seen = Kept.of(self._work, cost)

    def _last_violated(self) -> int:
        """Last node at which the trajectory that was measured last violates something; −1 if it does nowhere."""
        return self._work.result.last_violated

    def _compile(self) -> None:
        """Run every kernel once."""
        goal = self._problem.cost.state_goal.copy()
        self._set_guess(goal, None, None, None)
        self._begin(goal)
        guess.aim_straight(self._memory)
        self._measure()
        nominal.nominal_cost(self._model, self._memory)
        settle(self._model, self._memory, STEER)
        self._roll_out(0.0)
        self._accept()

    def _check_integrators(self) -> None:
        """Compare the rows that the problem calls integrators with the model's Jacobian."""
        m, nx, nu, work = self._problem.integrators, self._problem.nx, self._problem.nu, self._work
        if m == 0:
            return
        work.nominal.states[:], work.nominal.inputs[:] = self._problem.cost.state_goal, self._problem.cost.input_goal
        self._measure()
        jacobian = np.delete(work.linear.jacobians[0, :, : nx + 1 + nu], nx, axis=1)
        expected = np.zeros((m, nx + nu))
        expected[:, nx - m : nx] = np.eye(m)
        expected[:, nx + nu - m :] = self._problem.time_step * np.eye(m)
        others = jacobian[: nx - m, [*range(nx - m, nx), *range(nx + nu - m, nx + nu)]]
        if not np.allclose(jacobian[nx - m :], expected, atol=1e-7) or np.abs(others).max(initial=0.0) > 1e-7:
            raise SolverError(
                "the last states are not integrators of the last inputs", field="problem.integrators", given=m,
                allowed="x⁺ = x + Δt u, and no other state depends on them",
            )  # fmt: skip
