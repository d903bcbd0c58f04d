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
from doorman.exceptions import SolverError
from doorman.kinematics.numbers import Numbers
from doorman.kinematics.vehicles.arms.arm_pattern import ArmPattern
from doorman.model import Model
from doorman.ocp.kernels.printed.printed_problem import kept_text
from doorman.ocp.problem.columns import column
from doorman.ocp.problem.terms import Constraint, Cost, Residual

MakeTask = Callable[[ArmPattern, tuple[str, ...], Numbers], Any]
"""Makes a symbolic task; it imports CasADi, and is called where the text is not on disk yet."""


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


def task_text(
    name: str, make_task: MakeTask, model: Model, numbers: Numbers, list_rows: Callable[[Any], list[Constraint]],
    extras: Extras, list_costs: Callable[[Any], list[Residual]] = lambda task: [],
) -> str:  # fmt: skip
    """Text of a door problem."""
    pattern, _ = ArmPattern.of(model.vehicle.arm)
    points = model.vehicle.point_names

    def text() -> str:
        import casadi as ca

        task = make_task(pattern, points, numbers)
        constraints = [*list_rows(task), *(_resolved(each, task) for each in extras.constraints)]
        costs = [*list_costs(task), *(_resolved(each, task) for each in extras.costs)]
        timed = any(ca.depends_on(ca.SX(each.expression), task.time) for each in (*constraints, *costs))
        return str(task.symbolic_model(timed).text(constraints, costs))

    if extras.constraints or extras.costs:
        return text()
    return kept_text(f"{name} {pattern} {points} {numbers.sizes}", text, _MAKERS)


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
