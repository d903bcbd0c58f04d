"""Problems from CasADi expressions: dynamics, constraints and costs are written once, derivatives and kernels follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NoReturn

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from doorman.checks import number, per_node, vector
from doorman.exceptions import DimensionError, SolverError
from doorman.ocp.kernels.printed.module_text import module_text
from doorman.ocp.kernels.printed.printed_problem import printed_problem
from doorman.ocp.problem.columns import column
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.expressions import Expansion, Expressions
from doorman.ocp.problem.free_time import Stretched, check_guess, hidden_numbers, stretched_bounds, stretched_cost
from doorman.ocp.problem.integrators import INTEGRATORS, Integrator, discretized
from doorman.ocp.problem.problem import Bounds, FreeTime, Problem, check_count
from doorman.ocp.problem.terms import Constraint, Cost, Residual, Row


class SymbolicModel:
    """Dynamics in CasADi SX, of which problems are made.

    Parameters are numbers that change without compiling: of the whole problem, or of each node (references, obstacles that
    move). Weights of the quadratic cost, bounds and the time step are such numbers anyway.

    Args:
        x: Symbols of the state, (nx, 1).
        u: Symbols of the input, (nu, 1).
        dynamics: ẋ of these symbols, (nx, 1); x⁺ with `integrator="discrete"`.
        parameters: Symbols of the problem's parameters, (np, 1).
        node_parameters: Symbols of each node's parameters, (nq, 1).
        integrator: "rk4", "euler" or "discrete". Inputs and a node's parameters are held over the step.
        steps: Equal integration steps that make up a time step.
        domain: Expressions of the state that must be positive, as the cosine of a pitch angle; a step that leaves the domain
            has no number (NaN), which no solver takes for a solution.

    Raises:
        SolverError: if symbols are no SX symbols, or `dynamics` contains others.
        DimensionError: if `dynamics` has another size than the state.
    """

    def __init__(
        self, x: Any, u: Any, dynamics: Any, *, parameters: Any = None, node_parameters: Any = None,
        integrator: Integrator = "rk4", steps: int = 1, domain: Any = None,
    ) -> None:  # fmt: skip
        if integrator not in INTEGRATORS:
            raise SolverError("unknown", field="integrator", given=integrator, allowed=", ".join(INTEGRATORS))
        if not (isinstance(steps, (int, np.integer)) and steps >= 1):
            raise DimensionError("not a number of steps", field="steps", given=steps, allowed="an integer >= 1")
        self.x, self.u = _symbols("x", x), _symbols("u", u)
        self.parameters = _symbols("parameters", ca.SX(0, 1) if parameters is None else parameters)
        self.node_parameters = _symbols("node_parameters", ca.SX(0, 1) if node_parameters is None else node_parameters)
        self.integrator, self.steps = integrator, int(steps)
        self.time_step = ca.SX.sym("time_step")
        """Symbol of Δt [s]."""
        right = self._expression("dynamics", dynamics, inputs=True)
        if right.numel() != self.nx:
            raise DimensionError("wrong number of rows", field="dynamics", given=right.numel(), allowed=str(self.nx))
        symbols = [self.x, self.u, self.parameters, self.node_parameters]
        self._rate, rate = right, ca.Function("rate", symbols, [right])
        self.step = discretized(lambda state: rate(state, *symbols[1:]), self.x, self.time_step, integrator, self.steps)
        """x⁺ in symbols, (nx, 1)."""
        self._domain = self._expression("domain", [] if domain is None else domain, inputs=False)
        self._checked_step = self._inside(self._domain)

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a SymbolicModel cannot be copied or pickled, as your expressions refer to its symbols; its problems can"
        )

    @property
    def nx(self) -> int:
        """Number of states."""
        return int(self.x.numel())

    @property
    def nu(self) -> int:
        """Number of inputs."""
        return int(self.u.numel())

    def problem(
        self, horizon: int, time_step: float, cost: QuadraticCost, *, bounds: Bounds | None = None,
        constraints: Sequence[Constraint] = (), costs: Sequence[Cost | Residual] = (),
        parameters: ArrayLike = (), node_parameters: ArrayLike | None = None, second_derivatives: bool = True,
        free_time: FreeTime | None = None,
    ) -> Problem:  # fmt: skip
        """Problem of these dynamics; its kernels are compiled by the first solver of it, and kept on disk.

        Args:
            horizon: N, number of steps.
            time_step: Δt; with a free time, its guess [s].
            cost: Quadratic cost.
            bounds: Of states and inputs.
            constraints: Rows that must not be positive, lie between two ends, or are zero.
            costs: Terms on top of the quadratic cost.
            parameters: Values of the parameters, shape (np,).
            node_parameters: Values at nodes 0 … N, shape (N + 1, nq), or (nq,) for the same at all; zeros if not given.
            second_derivatives: Print the Hessian of the Lagrangian, too. Without it solvers take differences of slopes.
            free_time: Bounds and cost of the duration, where the solver chooses it.

        Returns:
            The problem.

        Raises:
            SolverError: if an expression contains an unknown symbol or an operation without translation, or a name twice, or
                the guess of a free time is outside its bounds.
            DimensionError: if a size does not fit.
        """
        check_count("horizon", horizon, 1)
        time_step = number(time_step, "time_step", "> 0 s")
        given = vector(parameters, self.parameters.numel(), "parameters")
        for name, size in (("cost.state_goal", self.nx), ("cost.input_goal", self.nu)):
            found = len(getattr(cost, name.partition(".")[2]))
            if found != size:
                raise DimensionError("wrong length", field=name, given=found, allowed=str(size))
        shape = (horizon + 1, int(self.node_parameters.numel()))
        at_nodes = per_node(np.zeros(shape) if node_parameters is None else node_parameters, shape).copy()
        if free_time is None:
            text = self.text(constraints, costs, second_derivatives)
            return printed_problem(text, horizon, time_step, cost, bounds, given, at_nodes)
        check_guess(free_time, horizon * time_step)
        if self.integrator == "discrete":
            raise SolverError("discrete dynamics have no duration", field="free_time", given=self.integrator,
                              allowed='"rk4" or "euler"')  # fmt: skip
        first = np.eye(horizon + 1, 1)
        hidden = hidden_numbers(cost, time_step, free_time)
        problem = printed_problem(
            self._free_text(constraints, costs, second_derivatives, cost.is_full), horizon, time_step, stretched_cost(cost),
            stretched_bounds(bounds or Bounds(), self.nx, self.nu, free_time, horizon * time_step),
            np.concatenate([hidden, given]), np.concatenate([at_nodes, first], axis=1),
        )  # fmt: skip
        return replace(problem, free_time=free_time, hidden_parameters=len(hidden))

    def text(
        self,
        constraints: Sequence[Constraint] = (),
        costs: Sequence[Cost | Residual] = (),
        second_derivatives: bool = False,
    ) -> str:
        """Python module that computes these expressions: all of a problem but its numbers; see `printed_problem`.

        Args:
            constraints: Rows that must not be positive, lie between two ends, or are zero.
            costs: Terms on top of the quadratic cost.
            second_derivatives: Print the Hessian of the Lagrangian, too.

        Raises:
            SolverError: if an expression contains an unknown symbol or an operation without translation, or a name twice.
            DimensionError: if a size does not fit.
        """
        return module_text(self._expressions(constraints, costs), second_derivatives)

    def _free_text(
        self,
        constraints: Sequence[Constraint],
        costs: Sequence[Cost | Residual],
        second_derivatives: bool,
        full: bool,
    ) -> str:
        """Text of a problem whose duration is free: that of a model with its stretch."""
        whole = Stretched.of(self.x, self.u, self.step, self.time_step, self.node_parameters, full)
        model = SymbolicModel(
            whole.x, whole.u, whole.dynamics, parameters=ca.vertcat(whole.hidden, self.parameters),
            node_parameters=whole.node_parameters, integrator="discrete", domain=self._domain,
        )  # fmt: skip
        _check_terms("costs", costs, (Cost, Residual))
        return model.text(constraints, whole.costs(costs, full), second_derivatives)

    def _inside(self, domain: Any) -> Any:
        """x⁺ without a number in the rows that a violated domain depends on."""
        step = ca.densify(self.step)
        for condition in ca.vertsplit(domain):
            after = ca.substitute(condition, self.x, self.step)
            for row in range(self.nx):
                if ca.depends_on(condition, self.x[row]):
                    step[row] = ca.if_else(after > 0, step[row], float("nan"))
        return step

    def _expressions(self, constraints: Sequence[Constraint], costs: Sequence[Cost | Residual]) -> Expressions:
        _check_terms("constraints", constraints, Constraint)
        _check_terms("costs", costs, (Cost, Residual))
        names = [term.name for term in (*constraints, *costs)]
        if len(set(names)) < len(names):
            twice = ", ".join(sorted({name for name in names if names.count(name) > 1}))
            raise SolverError("names must differ", field="constraints, costs", given=twice)
        rows: dict[str, list[tuple[Any, Row]]] = {"rows": [], "input_rows": [], "end_rows": []}
        for constraint in constraints:
            at_end = constraint.at == "end"
            expression = self._expression(constraint.name, constraint.expression, inputs=not at_end)
            kind = "end_rows" if at_end else "input_rows" if ca.depends_on(expression, self.u) else "rows"
            rows[kind] += [(row.expression / constraint.scale, row) for row in constraint.rows(expression, self._end)]
        at: dict[str, list[tuple[Any, Any]]] = {"stages": [], "end": []}
        for term in costs:
            at[term.at].append((term, self._expression(term.name, term.expression, inputs=term.at == "stages")))
        h, g, h_end = (ca.densify(ca.vertcat(ca.SX(0, 1), *(row for row, _ in each))) for each in rows.values())
        every = [row for each in rows.values() for _, row in each]
        return Expressions(
            self.x, self.u, self.time_step, self.parameters, self.node_parameters, ca.densify(self._rate),
            ca.densify(self.step), ca.densify(self._checked_step),
            h, g, h_end, tuple(row.name for row in every), tuple(row.equality for row in every),
            Expansion.of(at["stages"], ca.vertcat(self.x, self.u), self.time_step) if costs else None,
            Expansion.of(at["end"], self.x, ca.SX(1)) if costs else None,
        )  # fmt: skip

    def _end(self, name: str, given: Any) -> Any:
        """A column of numbers, or of expressions of parameters."""
        end = self._expression(
            name, ca.DM(given) if isinstance(given, (list, tuple, np.ndarray)) else given, inputs=False
        )
        if ca.depends_on(end, self.x):
            raise SolverError(
                "the bound depends on states", field=name, given=str(end), allowed="numbers, or parameters"
            )
        return end

    def _expression(self, name: str, expression: Any, inputs: bool) -> Any:
        """A column of SX, of known symbols."""
        entries = column(name, expression)
        known = [self.x, self.parameters, self.node_parameters, *([self.u] if inputs else [])]
        unknown = [str(s) for s in ca.symvar(entries) if not ca.depends_on(ca.vertcat(*known), s)]
        if unknown:
            allowed = ", ".join(str(symbol) for symbol in ca.symvar(ca.vertcat(*known)))
            raise SolverError("unknown symbols", field=name, given=", ".join(unknown), allowed=allowed)
        return entries


def _symbols(field: str, given: Any) -> Any:
    """A column of SX symbols."""
    if not (isinstance(given, ca.SX) and given.is_column() and (given.is_empty() or given.is_valid_input())):
        raise SolverError("not symbols", field=field, given=type(given).__name__, allowed="a column of casadi.SX.sym")
    return given


def _check_terms(field: str, given: Any, kinds: Any) -> None:
    """A sequence of terms, not one alone and not bare expressions."""
    allowed = "a list of Constraint" if field == "constraints" else "a list of Cost or Residual"
    if not isinstance(given, Sequence):
        raise SolverError("not a list", field=field, given=type(given).__name__, allowed=allowed)
    for place, term in enumerate(given):
        if not isinstance(term, kinds):
            raise SolverError("unknown term", field=f"{field}[{place}]", given=type(term).__name__, allowed=allowed)
