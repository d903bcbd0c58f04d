"""From lists of constraints and costs to the text of a problem: a door task's own, and the user's."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType, SimpleNamespace
from typing import Any

import doorman.collision
import doorman.dynamics
import doorman.kinematics
import doorman.planning
from doorman.collision.rows.listed import Kinds
from doorman.exceptions import SolverError
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.model import Model
from doorman.ocp.kernels.printed.printed_problem import kept_text, printed_problem
from doorman.ocp.problem.columns import column
from doorman.ocp.problem.costs import QuadraticCost
from doorman.ocp.problem.problem import Bounds, Problem
from doorman.ocp.problem.terms import Constraint, Cost, Residual

Made = tuple[Any, list[Constraint], list[Residual]]
"""A symbolic task, its rows and its costs."""


@dataclass(frozen=True)
class Extras:
    """What a user adds to a door problem."""

    constraints: tuple[Constraint, ...] = ()
    """Expressions, or functions of the task that return them."""
    costs: tuple[Cost | Residual, ...] = ()
    """Expressions, or functions of the task that return them."""

    @classmethod
    def of(cls, constraints: Sequence[Constraint], costs: Sequence[Cost | Residual]) -> Extras:
        """Checked constraints and costs of a user."""
        for field, given, kinds in (("constraints", constraints, (Constraint,)), ("costs", costs, (Cost, Residual))):
            for each in given:
                if not isinstance(each, kinds):
                    allowed = " or ".join(f"doorman.{kind.__name__}" for kind in kinds)
                    raise SolverError("wrong kind of object", field=field, given=type(each).__name__, allowed=allowed)
        return cls(tuple(constraints), tuple(costs))

    def rows_of(self, names: Sequence[str]) -> tuple[int, ...]:
        """Indices of a problem's rows that are the user's."""
        ours = "|".join(re.escape(each.name) for each in self.constraints) or "(?!)"
        return tuple(i for i, name in enumerate(names) if re.fullmatch(rf"({ours})( \d+)?( \[.*\])?", name))


_MAKERS = doorman.kinematics, doorman.dynamics, doorman.collision, doorman.planning
"""Packages whose code makes the text of a problem."""
NO_EXTRAS = Extras()
NOTHING: Mapping[str, Any] = MappingProxyType({})
"""No numbers that are given."""


def task_problem(
    name: str, make: Callable[[ArmPattern, tuple[str, ...], Numbers, Kinds], Made], model: Model, numbers: Numbers,
    cost: QuadraticCost, bounds: Bounds, extras: Extras,
) -> Problem:  # fmt: skip
    """Problem of a scenario's task. `make` imports CasADi, and is called where the problem's text is not on disk yet."""
    pattern, _ = ArmPattern.of(model.vehicle.arm)
    points, planner = model.vehicle.point_names, model.scenario.planner

    def make_text() -> str:
        import casadi as ca

        task, rows, costs = make(pattern, points, numbers, model.kinds)
        constraints = [*rows, *(_resolved(each, task) for each in extras.constraints)]
        costs = [*costs, *(_resolved(each, task) for each in extras.costs)]
        timed = any(ca.depends_on(ca.SX(each.expression), task.time) for each in (*constraints, *costs))
        return str(task.symbolic_model(timed).text(constraints, costs))

    if extras.constraints or extras.costs:
        text = make_text()
    else:
        text = kept_text(f"{name} {model.kinds} {pattern} {points} {numbers.sizes}", make_text, _MAKERS)
    return printed_problem(text, planner.horizon_steps, planner.time_step, cost, bounds, numbers.vector)


def _resolved(term: Any, task: Any) -> Any:
    """A term whose expression is one, and no function of the task any more; it must depend on what the task plans."""
    import casadi as ca

    expression = term.expression
    if callable(expression):
        try:
            expression = expression(task)
        except AttributeError as error:
            names = sorted(vars(error.obj)) if isinstance(error.obj, SimpleNamespace) else task.names()
            raise SolverError("unknown name", field=term.name, given=error.name, allowed=", ".join(names)) from error
    expression = column(term.name, expression)
    moving = ca.vertcat(task.state, task.inputs)
    if not ca.depends_on(expression, moving):
        raise SolverError(
            "does not apply to this task: no state and no input changes it", field=term.name,
            given=", ".join(str(expression[i]) for i in range(expression.numel())),
            allowed=f"an expression of {', '.join(str(each) for each in ca.symvar(moving))}",
        )  # fmt: skip
    return replace(term, expression=expression)
