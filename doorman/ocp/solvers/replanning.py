"""What controllers call again and again: real-time iterations from the last trajectory, aiming anew where that is no guess."""

from __future__ import annotations

import math
import time

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array, frozen
from doorman.checks import number
from doorman.exceptions import DimensionError, SolverError
from doorman.ocp.solvers.arguments import checked_budget, checked_state
from doorman.ocp.solvers.engine import StateGuess
from doorman.ocp.solvers.iterations import cold_start, guess, nominal, rollout
from doorman.ocp.solvers.iterations.real_time import KEEP_BETTER, RETURN, STEER, follow, settle
from doorman.ocp.solvers.kept import Kept
from doorman.ocp.solvers.memory.parts import Multipliers
from doorman.ocp.solvers.solution import PlanStatus
from doorman.ocp.solvers.solver import Solver
from doorman.ocp.solvers.stretch import divide_rest, time_step_of

EXTRA_ITERATIONS = 2
"""Largest number of iterations of a replan beyond the planned ones, and once more where these end outside or cost far more."""

MOST_SWEEPS = 6
"""Largest number of Riccati sweeps of a replan, but one an iteration: what more of them gain, the next replan gains, too."""

JUMP = 1.0
"""A sweep that changes an input by more than this, weighted by its cost, says that the previous trajectory is no guess."""

_LATEST_SHIFT = 2
"""Steps of the previous trajectory in which the present state is looked for."""

_RECOVERY_ITERATIONS = 60
"""Largest number of iterations of a replan that has to aim anew, where the caller gives no budget."""

_AIMING_ITERATIONS = 6
"""So many of them begin with the trajectory before: what more of them gain, the next replan gains, too."""


class Replanner(Solver):
    """A solver that goes on from its last trajectory."""

    def replan(
        self,
        state: ArrayLike,
        elapsed: float | None = None,
        *,
        iterations: int = 1,
        max_iterations: int | None = None,
        time_limit: float = math.inf,
    ) -> tuple[PlanStatus, int]:
        """Next plan of a controller: `follow`, and `aim_anew` where the last trajectory is no guess any more.

        That is so after a jump of state, goal or parameters, where following leads to nothing that may be flown, and where it
        leaves the constraints on its way. Solvers with a search also ask it where the trajectory seems to be far from an optimum.
        Without a trajectory to follow it is a solve from the input goal.
        """
        started = time.monotonic()
        first = checked_state(state, self._problem)
        if elapsed is not None:
            elapsed = number(elapsed, "elapsed", "a finite time [s]")
        budget = checked_budget(self._recovery_iterations() if max_iterations is None else max_iterations, time_limit)
        if not self._started:
            return self.run(first, max_iterations=budget, time_limit=time_limit)
        shift = -1.0 if elapsed is None else min(max(elapsed / self.time_step, 0.0), self._problem.horizon)
        most, extra = (iterations, EXTRA_ITERATIONS) if max_iterations is None else (budget, 0)
        if self._problem.free_time is not None:
            shift = self._divide_rest(first, shift)
        status = self._follow(first, shift, _LATEST_SHIFT, most, started, time_limit, extra)
        done, left = self._work.result.iterations, time_limit - (time.monotonic() - started)
        wild = self._work.result.change > JUMP or self._is_far_off()
        if (wild or self._leads_astray(status)) and done < budget and left > 0.0:
            status, more = self.aim_anew(first, status, budget - done, left)
            done += more
        self._note(status)
        return status, done

    def _recovery_iterations(self) -> int:
        """Largest number of iterations of a replan that has to aim anew."""
        return _RECOVERY_ITERATIONS

    def _leads_astray(self, status: PlanStatus) -> bool:
        """Whether a trajectory may not be flown, or leaves the constraints on its way; a start outside shows at once."""
        return not status.flyable or (not status.usable and self._work.result.node > 1)

    def _first_share(self, max_iterations: int) -> int:
        """Iterations of these for the trajectory before."""
        return max(min(max_iterations // 2, _AIMING_ITERATIONS), 1)

    def _is_far_off(self) -> bool:
        """Whether the trajectory seems to be far from an optimum, and something else than following finds one."""
        return False

    def _note(self, status: PlanStatus) -> None:
        """Remember what the next `replan` begins with."""
        self._started = status.flyable
        self._last_cost = self.cost if status.flyable else math.inf

    def _best(self, status: PlanStatus) -> PlanStatus:
        best = super()._best(status)
        self._note(best)
        return best

    def _set_guess(
        self, state: Array, inputs: ArrayLike | None, states: ArrayLike | StateGuess | None,
        multipliers: Multipliers | None, time_step: float | None = None,
    ) -> None:  # fmt: skip
        self._started = False  # an interrupt leaves no trajectory to follow
        super()._set_guess(state, inputs, states, multipliers, time_step)

    def aim_anew(
        self, state: Array, followed: PlanStatus, max_iterations: int, time_limit: float
    ) -> tuple[PlanStatus, int]:
        """Solve from the trajectory before the last `follow`, and from the input goal where neither may be flown.

        What is usable stays in the solver's memory rather than what is only flyable; of two that are either, the cheaper one, in
        which violations have the price of `options.largest_multiplier`.
        """
        before, worth = None, math.inf
        if followed.flyable:
            before, worth = Kept.of(self._work, self.cost), self._worth(followed)
        status, iterations = self._aim(state, max_iterations, time_limit, followed.flyable)
        cheaper = status.flyable and self._worth(status) <= worth
        if before is None or (cheaper if status.usable is followed.usable else status.usable):
            return status, iterations
        self._put_back_whole(before)
        return followed, iterations

    def _worth(self, status: PlanStatus) -> float:
        """Cost of the nominal trajectory, with a price for what it violates beyond the tolerance."""
        price = 0.0 if status.usable else self.options.largest_multiplier
        return self.cost + price * self._work.result.infeasibility

    def _aim(self, state: Array, max_iterations: int, time_limit: float, once: bool) -> tuple[PlanStatus, int]:
        """Solve from the inputs before the last `follow`, and unless this is enough from the input goal."""
        deadline, last = time.monotonic() + time_limit, self._work.first.inputs.copy()
        status, iterations = self.run(
            state, last[:, : self._problem.given_inputs], max_iterations=self._first_share(max_iterations),
            time_limit=time_limit, time_step=time_step_of(self._problem, last),
        )  # fmt: skip
        left = deadline - time.monotonic()
        if status.flyable or once or iterations >= max_iterations or left <= 0.0:
            return status, iterations
        status, more = self.run(state, max_iterations=max_iterations - iterations, time_limit=left)
        return status, iterations + more

    def _divide_rest(self, state: Array, shift: float) -> float:
        """Divide what is left of a free time anew; the shift that remains for `follow`, none."""
        nominal, even = self._work.nominal, np.ones_like(state)
        even[-1] = 0.0  # the stretch is no place
        if shift < 0.0:
            shift = guess.nearest_shift(nominal.states, state, even, _LATEST_SHIFT)
        divide_rest(self._work, shift)
        return 0.0

    def follow(
        self,
        state: Array,
        shift: float,
        limit: int,
        max_iterations: int = 1,
        time_limit: float = math.inf,
        extra_iterations: int = EXTRA_ITERATIONS,
    ) -> PlanStatus:
        """Real-time iteration: shift the last trajectory and its multipliers to `state`, iterate, roll out.

        Full steps, no line search: after a jump of state or goal, `solve` or `aim_anew` finds what this may not.
        """
        if not self._started:
            raise SolverError("there is no trajectory to follow", field="follow", allowed="after solve, run or replan")
        first, max_iterations = checked_state(state, self._problem), checked_budget(max_iterations, time_limit)
        if math.isnan(shift):
            raise DimensionError("the shift is NaN", field="shift", given=shift, allowed="a number of steps")
        return self._follow(first, shift, limit, max_iterations, time.monotonic(), time_limit, extra_iterations)

    def _follow(
        self, first: Array, shift: float, limit: int, max_iterations: int, started: float, time_limit: float, extra: int
    ) -> PlanStatus:
        """`follow` from a checked state; an interrupt leaves the trajectory before it."""
        result, model, memory = self._work.result, self._model, self._memory
        self._deadline, self._gave_up = started + 0.5 * time_limit, False
        try:
            code = follow(
                model, memory, first, float(min(shift, self._problem.horizon)), limit, max_iterations, extra, MOST_SWEEPS,
                started + time_limit, self._last_cost,
            )  # fmt: skip
            if code < rollout.DONE or (code >= 0 and not self._resume(code)):
                if not result.guess < math.inf:
                    self._go_back()
                    return PlanStatus.DIVERGED
                result.rolled = math.inf
                settle(model, memory, RETURN)
            elif code >= 0:
                self._accept()
                settle(model, memory, KEEP_BETTER)
        except BaseException:
            self._go_back()
            settle(model, memory, STEER)
            raise
        self._raise_failure()
        if result.violation <= self.options.feasibility:
            return PlanStatus.ITERATION_LIMIT
        return PlanStatus.RECOVERING if self._returns() else PlanStatus.INFEASIBLE

    def _go_back(self) -> None:
        """Trajectory before the last `follow`, without feedback and multipliers: what follows must not begin with its numbers."""
        np.copyto(self._work.nominal.states[0], self._work.first.states[0])
        np.copyto(self._work.nominal.inputs, self._work.first.inputs)
        guess.roll_blindly(self._model, self._memory, 0)
        cold_start.forget_policy(self._memory)
        self._forget_multipliers()
        self._measure()
        self._work.result.cost = nominal.nominal_cost(self._model, self._memory)

    @property
    def sweeps(self) -> int:
        """Riccati sweeps of the last `follow`."""
        return self._work.result.sweeps

    @property
    def cost(self) -> float:
        """J of the last trajectory."""
        return self._work.result.cost

    def worst(self) -> tuple[float, int, int]:
        """Largest violation of the last trajectory, its node and its row."""
        result = self._work.result
        return result.violation, result.node, result.row

    def worst_rows(self) -> Array:
        """Largest value of every row along the last trajectory, in the order of `Problem.constraint_names`."""
        nominal = self._work.nominal
        return np.concatenate([nominal.rows.max(axis=0), nominal.input_rows.max(axis=0), nominal.end_rows])

    def trajectory(self) -> tuple[Array, Array]:
        """Read-only copies of the last trajectory's states (N + 1, nx) and inputs (N, nu)."""
        nominal, nx, nu = self._work.nominal, self._problem.given_states, self._problem.given_inputs
        return frozen(nominal.states[:, :nx]), frozen(nominal.inputs[:, :nu])

    @property
    def time_step(self) -> float:
        """Δt of the last trajectory [s]."""
        return time_step_of(self._problem, self._work.nominal.inputs)

    def _returns(self) -> bool:
        """Whether the nominal trajectory starts outside the constraints and ends inside."""
        return not self._gave_up and 0 <= self._last_violated() < self._problem.horizon

    def _compile(self) -> None:
        self._started, self._last_cost = False, math.inf
        super()._compile()

    def _compile_follow(self) -> None:
        goal = self._problem.cost.state_goal.copy()
        follow(self._model, self._memory, goal, -1.0, 2, 1, 0, 1, 0.0, math.inf)
        self._go_back()
