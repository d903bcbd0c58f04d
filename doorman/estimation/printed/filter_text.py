"""The functions of a filter, from its expressions, and the module that holds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import casadi as ca

from doorman.estimation.expressions import checked_column
from doorman.estimation.hypothesis import Hypothesis, Row
from doorman.estimation.measurement import Measurement
from doorman.estimation.model import ProcessModel
from doorman.estimation.output import Output
from doorman.estimation.printed.functions import Function
from doorman.exceptions import DimensionError

_HEAD = '''"""Kernels of a filter, printed from CasADi expressions.

States x: {x}. Inputs u: {u}. Parameters p: {p}. Hypotheses: {hypotheses}. Measurements: {measurements}.
"""

import numpy as np

from doorman.numba_types.straight import straight'''


def functions_of(
    model: ProcessModel, measurements: Sequence[Measurement], hypotheses: Sequence[Hypothesis],
    switching: Mapping[tuple[str, str], Any], outputs: Sequence[Output],
) -> list[Function]:  # fmt: skip
    """Predictions, held rows, rates of switching and outputs of all hypotheses, in this order, then the measurements."""
    return [
        *(_prediction(model, each) for each in hypotheses),
        *(_held(model, each) for each in hypotheses),
        *(_rates(model, each, hypotheses, switching) for each in hypotheses),
        *(_outputs(model, each, outputs) for each in hypotheses),
        *(each for measurement in measurements for each in _measurement(model, measurement, hypotheses)),
    ]


def text_of(
    model: ProcessModel, functions: Sequence[Function], hypotheses: Sequence[Hypothesis],
    measurements: Sequence[Measurement],
) -> str:  # fmt: skip
    """The module's text: the same for the same expressions."""
    symbols = {"x": model.state, "u": model.inputs, "p": model.parameters}
    words = {name: ", ".join(map(str, ca.symvar(each))) or "none" for name, each in symbols.items()}
    head = _HEAD.format(
        hypotheses=", ".join(each.name for each in hypotheses),
        measurements=", ".join(each.name for each in measurements) or "none", **words,
    )  # fmt: skip
    symbols["h"] = model.time_step
    return (
        "\n\n\n".join(
            part.strip("\n") for part in (head, *(each.text(symbols) for each in dict.fromkeys(functions) if each.size))
        )
        + "\n"
    )


def _prediction(model: ProcessModel, hypothesis: Hypothesis) -> Function:
    dynamics, noise = model.dynamics, model.noise
    if hypothesis.dynamics is not None:
        dynamics = model.checked_dynamics(f"{hypothesis.name}.dynamics", hypothesis.dynamics)
    if hypothesis.noise is not None:
        noise = model.checked_noise(f"{hypothesis.name}.noise", hypothesis.noise)
    after = ca.densify(model.step(dynamics))
    spread = model.time_step * ca.mtimes(noise, noise.T)
    return Function(f"predict_{hypothesis.name}", [after], ca.jacobian(after, model.state), spread)


def _held(model: ProcessModel, hypothesis: Hypothesis) -> Function:
    def stacked(rows: Sequence[Row], part: str) -> Any:
        columns = [ca.SX(0, 1)]
        for row in rows:
            field = f"{hypothesis.name}.{row.name}"
            expression = checked_column(field, row.expression, model.symbols)
            columns.append(
                expression if part == "expression"
                else _for_each(f"{field}.{part}", getattr(row, part), model.symbols, expression.numel())
            )  # fmt: skip
        return ca.vertcat(*columns)

    every = [*hypothesis.holds, *hypothesis.limits]
    rows, deviations = stacked(every, "expression"), stacked(every, "deviation")
    equalities = int(stacked(hypothesis.holds, "expression").numel())
    slopes = ca.jacobian(rows, model.state)
    return Function(
        f"hold_{hypothesis.name}", [rows, deviations**2, stacked(every, "lasts")], slopes, equalities=equalities
    )


def _rates(
    model: ProcessModel, hypothesis: Hypothesis, hypotheses: Sequence[Hypothesis], switching: Mapping[Any, Any]
) -> Function:
    rates = [
        checked_column(f"switching[{hypothesis.name}, {each.name}]", rate, model.symbols, 1)
        for each in hypotheses
        for rate in [switching.get((hypothesis.name, each.name), 0.0)]
    ]
    switches = [ca.vertcat(*rates)] if len(rates) > 1 else []
    return Function(f"switch_{hypothesis.name}", switches, ca.SX(0, model.size))


def _outputs(model: ProcessModel, hypothesis: Hypothesis, outputs: Sequence[Output]) -> Function:
    values = [
        checked_column(f"{each.name}", each.under.get(hypothesis.name, each.expression), model.symbols, 1)
        for each in outputs
    ]
    column = ca.vertcat(ca.SX(0, 1), *values)
    return Function(f"output_{hypothesis.name}", [column], ca.jacobian(column, model.state))


def _measurement(model: ProcessModel, measurement: Measurement, hypotheses: Sequence[Hypothesis]) -> list[Function]:
    """One function for each hypothesis, the same for all that the measurement does not name."""
    rows = checked_column(measurement.name, measurement.expression, model.symbols)
    if not rows.numel():
        raise DimensionError("no rows", field=measurement.name, given=0, allowed="at least 1")
    deviation = _for_each(f"{measurement.name}.deviation", measurement.deviation, model.symbols, rows.numel())
    name = f"measure_{measurement.name}"
    common = Function(name, [rows, deviation**2], ca.jacobian(rows, model.state))
    found = []
    for each in hypotheses:
        if each.name in measurement.under:
            field = f"{measurement.name}.under[{each.name}]"
            own = checked_column(field, measurement.under[each.name], model.symbols, rows.numel())
            found.append(Function(f"{name}_under_{each.name}", [own, deviation**2], ca.jacobian(own, model.state)))
        else:
            found.append(common)
    return found


def _for_each(field: str, given: Any, known: Any, size: int) -> Any:
    """A column of one entry a row, also if one is given for all."""
    entries = checked_column(field, given, known)
    return ca.repmat(entries, size, 1) if entries.numel() == 1 else checked_column(field, given, known, size)
