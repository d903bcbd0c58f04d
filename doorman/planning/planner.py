"""Receding-horizon planner: a cold plan once, then warm plans at a fixed number of iterations."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.checks import number
from doorman.copying import CopiedWhole
from doorman.exceptions import DimensionError
from doorman.kinematics.numbers import Numbers
from doorman.model import Model
from doorman.ocp.problem.terms import Constraint, Cost, Residual
from doorman.ocp.solvers.hybrid import Hybrid
from doorman.ocp.solvers.options import SolverOptions
from doorman.ocp.solvers.solution import PlanStatus, row_name
from doorman.planning.composition import Extras
from doorman.planning.hinge import Hinge
from doorman.planning.model_base import Motion
from doorman.planning.plan import Plan
from doorman.planning.planning_model import planning_model
from doorman.scenario import Scenario

COLD_ITERATIONS = 200
"""Largest number of iterations of a cold plan."""
LARGEST_PRICE = 100.0
"""Price of a metre of violation, where the start is outside the constraints; inside, multipliers of a few units hold them."""


class Planner(CopiedWhole):
    """Planner of one scenario. The constructor compiles, or loads from the cache; plans never compile.

    Not to be shared between threads: it owns its memory. A copy, and what is unpickled, plans as the original would, and without
    touching it: with the same hinge, margin and previous plan.

    Args:
        scenario: The scenario, its name or path, or a model of it that exists already.
        options: Settings of the solver.
        constraints: Rows of your own beside the problem's: CasADi expressions, as functions of the symbolic task.
        costs: Cost terms of your own, likewise.

    Raises:
        DoormanError: if the scenario cannot be made a problem.
    """

    def __init__(
        self, scenario: Scenario | Model | str | os.PathLike[str], options: SolverOptions | None = None, *,
        constraints: Sequence[Constraint] = (), costs: Sequence[Cost | Residual] = (),
    ) -> None:  # fmt: skip
        self.model = scenario if isinstance(scenario, Model) else Model(scenario)
        self.settings = self.model.scenario.planner
        self.planning = planning_model(self.model)
        extras = Extras.of(constraints, costs)
        self._problem = self.planning.problem(extras)
        names, rows = self._problem.constraint_names, extras.rows_of(self._problem.constraint_names)
        self._user_rows = {names[row]: row for row in rows}
        usual = SolverOptions(
            largest_multiplier=LARGEST_PRICE, hessian="gauss-newton", feasibility=self.planning.tolerance
        )
        self.solver = Hybrid(self._problem, options or usual)
        self._motion = Motion(self.solver.problem)
        self._fitted = False
        self._numbers = self.planning.numbers
        self.update_time(0.0)
        self._hinge = Hinge.of(self.model.door)
        self._margin = self.settings.margin
        self._goal_angle: float | None = None
        self._given: dict[str, ArrayLike] = {}

    def update_door(
        self, *, friction: float | None = None, disturbance: float | None = None, inertia: float | None = None,
        damping: float | None = None, stiffness: float | None = None,
    ) -> None:  # fmt: skip
        """Change what the next plans take the hinge to do; the scenario's values hold until the first call.

        Args:
            friction: τ_c [N m].
            disturbance: τ_d of α̈ = … − τ_d/I_D, in the sense of damping: negative where it resists opening [N m].
            inertia: I_D of the leaf about the hinge [kg m²].
            damping: b [N m s/rad].
            stiffness: k of a spring or closer [N m/rad].

        Raises:
            DimensionError: if a value is not finite, the inertia not positive, or another but the disturbance negative.
        """
        hinge = self._hinge.changed(
            friction=friction, disturbance=disturbance, inertia=inertia, damping=damping, stiffness=stiffness
        )
        if hinge != self._hinge:
            self._hinge, self._fitted = hinge, False

    def update_margin(self, margin: float) -> None:
        """Change the distance that the next plans keep from door and frame; `planner.margin` holds until the first call.

        Args:
            margin: Not negative [m].

        Raises:
            DimensionError: if it is negative or not finite.
        """
        wanted = number(margin, "margin", "finite, >= 0 [m]")
        if wanted < 0.0:
            raise DimensionError("not a margin", field="margin", given=margin, allowed="finite, >= 0 [m]")
        if wanted != self._margin:
            self._margin, self._fitted = wanted, False

    def update_goal(self, door_angle: float | None) -> None:
        """Change where the next plans bring a gripped door: to rest there, with the heading and arm that keep step with it.

        Args:
            door_angle: α, clipped to the way from start to goal [rad]; None: the scenario's goal.

        Raises:
            DimensionError: if it is not finite.
        """
        if door_angle is not None:
            door_angle = number(door_angle, "door_angle", "finite [rad]")
        if door_angle != self._goal_angle:
            self._goal_angle, self._fitted = door_angle, False

    def update_time(self, time: float) -> None:
        """Say what `task.time` is at the first node of the next plans, for constraints and costs that change with it.

        Args:
            time: [s].

        Raises:
            DimensionError: if it is not finite.
        """
        time = number(time, "time", "finite [s]")
        nodes = self.solver.problem.model.node_parameters
        if nodes.shape[1]:
            steps = self.settings.time_step * np.arange(len(nodes))
            self.solver.update_parameters(node_parameters=(time + steps)[:, None])

    def update_numbers(self, changes: Mapping[str, ArrayLike]) -> None:
        """Give numbers of the task, as references and weights, that the next plans take instead of what would fit.

        Args:
            changes: By the names of `planning.numbers`; empty: nothing but what fits.

        Raises:
            DimensionError: if a name is unknown, or stands for another count of numbers.
        """
        self.planning.numbers.replaced(changes)
        self._given, self._fitted = dict(changes), False

    @property
    def start_state(self) -> Array:
        """The scenario's start at rest, as `plan` takes it: shape (nx,), see `planning.state_names`, SI units."""
        return self.planning.start_state

    @property
    def numbers(self) -> Numbers:
        """Numbers of the task, as the last plan took them."""
        return self._numbers

    @property
    def margin(self) -> float:
        """Distance that plans keep from door and frame [m]."""
        return self._margin

    def normal_forces(self, plan: Plan) -> Array:
        """Force of the tip on the door along its normal, at every node but the last; positive where it presses.

        Args:
            plan: This planner's last plan.

        Returns:
            λ_n, shape (N,) [N].
        """
        return self.planning.normal_forces(self._numbers, plan.states, plan.inputs)

    def user_rows(self) -> dict[str, float]:
        """Largest value along the last plan of every row that the user has added, by name; positive where it is violated."""
        if not self._user_rows:
            return {}
        worst = self.solver.worst_rows()
        return {name: float(worst[row]) for name, row in self._user_rows.items()}

    def _fit(self, state: Array) -> None:
        """Fit the problem to hinge, margin and start, where that changes anything."""
        if self._fitted and not self.planning.follows_start(self._given):
            return
        self._numbers = self.planning.fitted(self._hinge, self._margin, state, self._given, self._goal_angle)
        self.solver.update_parameters(self._numbers.vector)
        self.solver.update_goal(self.planning.goal(state, self._hinge, self._goal_angle))
        self._fitted = True

    def carried(self, state: ArrayLike, under_way: Sequence[Array]) -> Array:
        """The state once inputs that were given before have acted: a plan of what is sent now begins there.

        Args:
            state: x, shape (nx,).
            under_way: Inputs in the order in which they act, each for one step of the plan, shape (nu,).

        Returns:
            The state by the planner's own model, shape (nx,).

        Raises:
            DimensionError: if the state has another shape or is not finite.
            SingularityError: if its pitch is not inside ±90°.
        """
        x = self.planning.check_state(state)
        if not len(under_way):
            return x
        self._fit(x)
        self._motion.know(self._numbers.vector)
        for inputs in under_way:
            before, x = x, self._motion(x, inputs)
            for angle, rate in self.planning.headings:
                x[angle], x[rate] = before[angle] + self.settings.time_step * before[rate], before[rate]
        return x

    def plan(self, state: ArrayLike, *, max_iterations: int = COLD_ITERATIONS, time_limit: float = math.inf) -> Plan:
        """Plan from hover inputs until converged.

        Args:
            state: x, shape (nx,); [Φ, α, α̇, H] with the quasi-static model.
            max_iterations: Largest number of iterations.
            time_limit: No iteration but the first begins that would not be over by then, if it takes as long as the longest so
                far; constraints that are hard to hold are given up then [s].

        Returns:
            The plan; its status says whether it may be flown.

        Raises:
            DimensionError: if the state has another shape or is not finite, or a budget is not positive.
            SingularityError: if its pitch is not inside ±90°.
        """
        started = time.perf_counter()
        x = self.planning.check_state(state)
        self._fit(x)
        status, iterations = self.solver.run(x, max_iterations=max_iterations, time_limit=time_limit)
        return self._plan(status, iterations, started)

    def replan(
        self,
        state: ArrayLike,
        elapsed: float | None = None,
        *,
        max_iterations: int | None = None,
        time_limit: float = math.inf,
    ) -> Plan:
        """Plan from the previous plan, shifted with its multipliers, with the few iterations that a replan has.

        Where there is no previous plan the plan is cold. The planner aims anew within the budget where the previous plan is no
        guess any more, as after a jump of the state or of the door's parameters, or where it leads out of the constraints.
        Without a budget it may miss the deadline then. Where nothing usable comes of that, the plan is the previous one bent
        to the state, if that is usable.

        Args:
            state: x, shape (nx,); [Φ, α, α̇, H] with the quasi-static model.
            elapsed: Time since the previous plan's state [s]; by default the previous plan is shifted to where it passes
                nearest to `state` within its first two steps.
            max_iterations: Largest number of iterations; by default those few, and more only to aim anew.
            time_limit: See `plan`. What is found by then is returned, with a status that says what holds [s].

        Returns:
            The plan; its status says whether it may be flown.

        Raises:
            DimensionError: if the state has another shape, or state, time or budget is not finite.
            SingularityError: if its pitch is not inside ±90°.
        """
        started = time.perf_counter()
        x = self.planning.check_state(state)
        self._fit(x)
        status, iterations = self.solver.replan(
            x, elapsed, iterations=self.settings.iterations, max_iterations=max_iterations, time_limit=time_limit
        )
        return self._plan(status, iterations, started)

    def _plan(self, status: PlanStatus, iterations: int, started: float) -> Plan:
        """What the solver's memory holds, as a plan."""
        states, inputs = self.solver.trajectory()
        violation, node, row = self.solver.worst()
        words = f"{row_name(self._problem, row)} by {violation:.3g} at node {node}" if violation > 1e-6 else ""
        impossible = self.planning.impossible(self._hinge, states[0]) if self._goal_angle is None else None
        if impossible is not None:
            status, words = impossible
        return Plan(
            states=states,
            inputs=inputs,
            cost=self.solver.cost if status.flyable else math.inf,
            max_violation=violation,
            iterations=iterations,
            status=status,
            solve_time=time.perf_counter() - started,
            time_step=self.settings.time_step,
            violated=words,
        )
