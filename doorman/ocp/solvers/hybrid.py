"""The default solver: augmented Lagrangian iterations and a rollout, and an interior-point search where they fail."""

from __future__ import annotations

import math
import time
from typing import Literal

import numpy as np

from doorman.arrays import Array
from doorman.numba_types.handles import held
from doorman.ocp.kernels import functions
from doorman.ocp.solvers.engine import FAST_ITERATIONS, Given, StateGuess
from doorman.ocp.solvers.interior.certificate import is_minimum
from doorman.ocp.solvers.interior.iterate import search
from doorman.ocp.solvers.interior.memory import Interior
from doorman.ocp.solvers.iterations import augmented_lagrangian as kernels
from doorman.ocp.solvers.iterations import cold_start, nominal, rollout
from doorman.ocp.solvers.iterations.careful import iterate_carefully
from doorman.ocp.solvers.iterations.real_time import DEARER
from doorman.ocp.solvers.kept import Kept
from doorman.ocp.solvers.order import is_last_first
from doorman.ocp.solvers.replanning import Replanner
from doorman.ocp.solvers.solution import PlanStatus
from doorman.ocp.solvers.telling import Stopped

_FIRST_ITERATIONS = 12
"""Largest number of fast iterations before the search: where they do well, they need no more."""

_PATIENCE = 4
"""Fast iterations whose active set has not settled by then give way to the search: they take many sweeps each."""
_SEARCH_ITERATIONS = 240
"""Enough for a search in either half of a replan that aims anew."""
_FAR_OFF = 0.1
"""Share of |J| that a replan's last sweep may promise; where it promises more, and more than the accuracy of one iteration, the
square root of the tolerance, the search runs."""
_POLISHING = 6
"""Largest number of fast iterations from a solution of the search, or from a rollout that costs something else."""


class Hybrid(Replanner):
    """Fast iterations and a rollout, and an interior-point search where these do not end at a minimum.

    The fast iterations find the active set of the whole horizon at once and need not satisfy the dynamics. The rollout makes of
    their result a trajectory that satisfies dynamics and nonlinear constraints. With `hessian="gauss-newton"` careful
    iterations take the place of the search: they need no second derivatives, and lead back where a start is outside.
    """

    _interior: Interior
    """Memory of the search, where it takes part."""

    def _solve(self, state: Array, max_iterations: int, deadline: float) -> tuple[PlanStatus, int]:
        solve = self._solve_thoroughly if self._is_curved else self._solve_fast
        return solve(state, max_iterations, deadline)

    def _solve_fast(self, state: Array, max_iterations: int, deadline: float) -> tuple[PlanStatus, int]:
        """Fast iterations, and careful ones: from the first guess where they fail, or from where full steps do not settle."""
        result, begun = self._work.result, time.monotonic()
        code = self._attempt(state, min(max_iterations, FAST_ITERATIONS), deadline)
        if code == cold_start.INVALID_START:
            return PlanStatus.INVALID_STATE, 0
        iterations, now = result.iterations, time.monotonic()
        deadline -= result.rollout_time
        late = deadline - now < now - begun  # it was time that ended it
        if code != cold_start.NOT_CONVERGED or iterations >= max_iterations or late:
            status, left = self._ended(code), min(max_iterations - iterations, _POLISHING)
            if status is PlanStatus.ITERATION_LIMIT and left > 0 and not late:
                status = self._polished(state, left, deadline)
                iterations += result.iterations
            if status is not PlanStatus.ITERATION_LIMIT or iterations >= max_iterations or late:
                return status, iterations
            self._remember()
        self._put_guess("first", state)
        left = max_iterations - iterations
        code = self._teller.run("careful", lambda: self._iterate_carefully(left, deadline), kernels.PAUSED)
        iterations += result.iterations
        result.expected = nominal.nominal_cost(self._model, self._memory)
        status = self._ended(cold_start.NOT_CONVERGED)
        settled = status.usable and code == kernels.CONVERGED and (self._agrees() or self._returns())
        return PlanStatus.CONVERGED if settled else status, iterations

    def _polished(self, state: Array, iterations: int, deadline: float) -> PlanStatus:
        """Full steps from a rollout that costs something else than what was rolled out: violations fall with each."""
        self._remember()
        now = time.monotonic()
        followed = self._follow(state, 0.0, 1, iterations, now, deadline - now, 0)
        self._teller.tell("fast")
        return PlanStatus.CONVERGED if followed.usable and self._agrees() else followed

    def _iterate_carefully(self, max_iterations: int, deadline: float) -> int:
        """Careful iterations from the nominal trajectory; their code."""
        return int(iterate_carefully(self._model, self._memory, max_iterations, deadline))

    def _solve_thoroughly(self, state: Array, max_iterations: int, deadline: float) -> tuple[PlanStatus, int]:
        """Fast iterations, and the interior-point search where they do not find a minimum: the cheapest of what there is.

        Results that differ say that there are several minima; the search then begins elsewhere, too, until two results agree.
        With multipliers the guess is an earlier solution, whose minimum needs no check; differences of slopes allow none.
        """
        given, result = self._given, self._work.result
        fast = given.multipliers or self.options.hessian != "exact"
        most = FAST_ITERATIONS if given.multipliers else _FIRST_ITERATIONS if fast else 1
        code = self._attempt(state, min(max_iterations, most), deadline, None if given.multipliers else _PATIENCE)
        if code == cold_start.INVALID_START:
            return PlanStatus.INVALID_STATE, 0
        iterations, resort = result.iterations, Kept.of(self._work, np.inf)
        best = on_top = self._found(code) if fast else None
        if best is not None and (given.multipliers or not self._is_exact or self._is_minimum(best)):
            return PlanStatus.CONVERGED, iterations
        for start in ("first", "held", "straight") if given.inputs or given.states else ("held", "straight", "first"):
            if iterations >= max_iterations or time.monotonic() >= deadline:
                break
            self._put_guess(start, state)
            on_top = None
            try:
                code = self._search(max_iterations - iterations, deadline)
            except Stopped:
                if best is None:
                    raise
                self._teller.callback = None
                break
            iterations += result.iterations
            if code == kernels.CONVERGED:
                on_top = self._settled(state, deadline)
                iterations += result.iterations
            elif self._rolled_search() is not None:
                self._remember()
            if on_top is not None:
                alone, agree = best is None, best is not None and on_top.costs_as(best)
                best = on_top if best is None or on_top.cost < best.cost else best
                if alone or agree:
                    break
        if best is not None and on_top is not best:
            self._put_back_whole(best)
        return PlanStatus.CONVERGED if best is not None else self._go_on_from(resort, state), iterations

    def _is_minimum(self, found: Kept) -> bool:
        """Whether a solution of the fast iterations, the nominal trajectory, is a minimum; its feedback stays."""
        holds = bool(is_minimum(self._model, self._memory, self._interior, 1.0 + abs(found.cost)))
        np.copyto(self._work.policy.gains, found.gains)
        return holds

    def _search(self, max_iterations: int, deadline: float) -> int:
        """Interior-point search from the nominal trajectory; its code."""
        arguments = self._model, self._memory, self._interior, max_iterations, deadline
        return self._teller.run("interior", lambda: int(search(*arguments)), kernels.PAUSED)

    def _settled(self, state: Array, deadline: float) -> Kept | None:
        """Solution of the search, rolled out by its own feedback, and closer to the optimum where fast iterations get there."""
        found = self._rolled_search()
        if found is None:
            return None
        self._given = Given(True, True, True)
        polished = self._found(self._attempt(state, _POLISHING, deadline, 1))
        if polished is not None and (polished.cost <= found.cost or polished.costs_as(found)):
            return polished
        self._put_back_whole(found)
        return found

    def _rolled_search(self) -> Kept | None:
        """Rollout of the search's solution; that itself, where a rollout leads elsewhere; None if neither is feasible."""
        work, result = self._work, self._work.result
        itself = Kept.of(work, result.cost)
        work.trial.states[0] = work.nominal.states[0]
        if rollout.roll_out(self._model, self._memory, -1, 0.0, 0) == rollout.DONE and self._feasible():
            rolled = Kept.of(work, result.cost)
            if rolled.costs_as(itself):
                self._accept()
                return Kept.of(work, rolled.cost)
        self._put_back_whole(itself)
        return itself if self._feasible() else None

    def _go_on_from(self, kept: Kept, state: Array) -> PlanStatus:
        """Fast iterations from where they ended, rolled out: what there is, where nothing has converged."""
        kept.put_back(self._work)
        self._given = Given(True, True, True)
        return self._ended(self._attempt(state, FAST_ITERATIONS, self._deadline))

    def _ended(self, code: int) -> PlanStatus:
        """Roll out what the fast iterations have ended with."""
        if code == cold_start.NOT_CONVERGED:
            return PlanStatus.ITERATION_LIMIT if self._start() else PlanStatus.DIVERGED
        if not self._rolled(code):
            return PlanStatus.DIVERGED
        return PlanStatus.CONVERGED if self._agrees() or self._returns() else PlanStatus.ITERATION_LIMIT

    def _found(self, code: int) -> Kept | None:
        """What `_attempt` has found, if it has converged, and its rollout agrees and is inside without ProxQP's help."""
        if code != rollout.DONE or not self._rolled(code):
            return None
        if not (self._agrees() and self._feasible()):
            self._remember()
            return None
        return Kept.of(self._work, self._work.result.cost)

    def _rolled(self, code: int) -> bool:
        """Finish a rollout of `_attempt`; False if it is not finite."""
        self._rollout_time += self._work.result.rollout_time
        return code == rollout.DONE or self._take(code >= 0 and self._resume(code))

    def _put_guess(self, start: StateGuess | Literal["first"], state: Array) -> None:
        """Nominal trajectory to begin with: what the fast iterations began with, or what a word describes."""
        self._forget_multipliers()
        if start == "first":
            np.copyto(self._work.nominal.states, self._work.first.states)
            np.copyto(self._work.nominal.inputs, self._work.first.inputs)
        else:
            self._draw_states(state, start, True)

    def _attempt(self, state: Array, max_iterations: int, deadline: float, patience: int | None = None) -> int:
        """Begin, fast iterations from the first guess, and where they converge the rollout: the code of `cold_start.solve`."""
        return self._teller.run(
            "fast",
            lambda: int(cold_start.solve(self._model, self._memory, state, *self._given, max_iterations, deadline)),
            cold_start.TO_RESUME,
            None if patience is None else lambda: self._settles(patience),
        )

    def _recovery_iterations(self) -> int:
        return _SEARCH_ITERATIONS if self._is_curved else super()._recovery_iterations()

    def _first_share(self, max_iterations: int) -> int:
        return max(max_iterations // 2, 1) if self._is_curved else super()._first_share(max_iterations)

    def _is_far_off(self) -> bool:
        if not self._is_curved:
            return False
        found, cost = self._work.result, abs(self._work.result.cost)
        promises = found.decrease > max(_FAR_OFF * cost, math.sqrt(self.options.tolerance) * (1.0 + cost))
        return promises or found.cost > DEARER * max(self._last_cost, found.expected)

    def _settles(self, patience: int) -> bool:
        """Whether the fast iterations have found their active set, or have not had so many iterations for it."""
        result = self._work.result
        return result.settled or result.iterations < patience

    def _agrees(self) -> bool:
        """Whether the rollout of the augmented Lagrangian's solution costs what that does."""
        cost, expected = self._work.result.cost, self._work.result.expected
        return bool(abs(cost - expected) <= kernels.ACCURACY * (1.0 + abs(expected)))

    def _begin(self, state: Array) -> bool:
        """Begin with one iteration: a kernel that begins and does nothing else is not needed."""
        return self._attempt(state, 1, 0.0) != cold_start.INVALID_START

    def _compile(self) -> None:
        if self._is_curved:
            self._interior = held(Interior.of(self._work))
        self._is_exact = functions.is_implemented(functions.curve_horizon, type(self._problem.model))
        if is_last_first():
            self._set_guess(self._problem.cost.state_goal.copy(), None, "held", None)
            self._compile_follow()
        super()._compile()
        if self._is_curved:
            search(self._model, self._memory, self._interior, 1, 0.0)
            is_minimum(self._model, self._memory, self._interior, 1.0)
        else:
            self._iterate_carefully(1, 0.0)
        self._compile_follow()

    @property
    def _is_curved(self) -> bool:
        """Whether the interior-point search takes part."""
        return self.options.hessian != "gauss-newton"
