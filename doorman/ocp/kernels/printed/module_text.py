"""Text of the module that computes one problem's expressions: a model type and its kernels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca
import numpy as np

from doorman.ocp.kernels.printed.curvature_text import curvature_text, prices_of
from doorman.ocp.kernels.printed.module_templates import (
    HEAD,
    HORIZON,
    HORIZON_ROWS,
    LINEARIZE_ROWS,
    LINEARIZE_STEP,
    NODE,
)
from doorman.ocp.kernels.printed.printing import printed
from doorman.ocp.problem.expressions import Expansion, Expressions, integrators_of


def module_text(expressions: Expressions, second_derivatives: bool = False) -> str:
    """The module's text: the same for the same expressions."""
    curvature, outputs = curvature_text(expressions) if second_derivatives else ("", 0)
    nodes = [NODE] if _has_nodes(expressions) else []
    parts = [_head(expressions, outputs), *nodes, *_step(expressions), *_state_rows(expressions)]
    parts += _rows(expressions, "constrain_input", "linearize_input_constraints", expressions.input_rows, expressions.u)
    parts += _rows(expressions, "constrain_end", "linearize_end_constraints", expressions.end_rows, ca.SX(0, 1))
    if expressions.stage_cost is not None and expressions.end_cost is not None:
        parts += _cost(expressions, "stage_cost", expressions.stage_cost, "model, x, u")
        parts += _cost(expressions, "end_cost", expressions.end_cost, "model, x")
    parts += [_horizon(expressions), *([curvature] if curvature else [])]
    return "\n\n\n".join(part.strip("\n") for part in parts) + "\n"


def _has_nodes(expressions: Expressions) -> bool:
    return not expressions.node_parameters.is_empty()


def _head(expressions: Expressions, outputs: int) -> str:
    x, u, p, q = expressions.x, expressions.u, expressions.parameters, expressions.node_parameters
    bent = 0 if expressions.stage_cost is None else x.numel() + u.numel()
    costs = [each for each in (expressions.stage_cost, expressions.end_cost) if each]
    squares = bent + max((_squares(each) + int(each.convex.nnz()) for each in costs), default=0)
    largest = max(_outputs(expressions.step, _both(expressions)), _outputs(expressions.rows, x), outputs)
    symbols = {
        name: ", ".join(str(symbol) for symbol in ca.symvar(each)) or "none"
        for name, each in (("x", x), ("u", u), ("p", p), ("q", q))
    }
    rows = tuple(each.numel() for each in (expressions.rows, expressions.input_rows, expressions.end_rows))
    return HEAD.format(
        nx=x.numel(), nu=u.numel(), nq=q.numel(), outputs=largest, bent=bent, squares=squares, prices=prices_of(expressions),
        rows=rows, integrators=integrators_of(expressions), names=expressions.names,
        equalities=expressions.equalities, **symbols,
    )  # fmt: skip


def _both(expressions: Expressions) -> Any:
    return ca.vertcat(expressions.x, expressions.u)


def _outputs(values: Any, z: Any) -> int:
    """How many numbers an expression and its Jacobian have."""
    return int(values.numel() + ca.jacobian(values, z).nnz())


def _step(expressions: Expressions) -> list[str]:
    slopes = ca.jacobian(expressions.step, _both(expressions))
    values = [expressions.checked_step]
    return [
        _plain_rate(expressions),
        _kernel(expressions, "step", "model, x, u, out", values, lambda k, i, v: f"out[{i}] = {v}"),
        _lanes(expressions, "step_lanes", "model, x, u, q, out", [expressions.checked_step, slopes]),
        _decorators(expressions, "linearize_step", "kernel") + LINEARIZE_STEP.format(spread=_spread_node(expressions)),
    ]


def _plain_rate(expressions: Expressions) -> str:
    """Kernel of ẋ: no solver calls it."""
    text = _kernel(expressions, "rate", "model, x, u, out", [expressions.rate], lambda k, i, v: f"out[{i}] = {v}")
    return text[text.index("@straight") :]


def _state_rows(expressions: Expressions) -> list[str]:
    """Kernels of h, where there are any."""
    rows, spread = expressions.rows, _spread_node(expressions)
    if not rows.numel():
        return []
    return [
        _kernel(expressions, "constrain", "model, x, h", [rows], lambda k, i, v: f"h[{i}] = {v}"),
        _lanes(expressions, "rows_lanes", "model, x, q, out", [rows, ca.jacobian(rows, expressions.x)]),
        _lanes(expressions, "row_values_lanes", "model, x, q, out", [rows]),
        _decorators(expressions, "linearize_constraints", "kernel") + LINEARIZE_ROWS.format(spread=spread),
    ]


def _spread_node(expressions: Expressions) -> str:
    return "\n    spread(model.q, model.q_lanes)" if _has_nodes(expressions) else ""


def _rows(expressions: Expressions, name: str, slopes_name: str, rows: Any, inputs: Any) -> list[str]:
    """Kernels of g or h_N, where there are any."""
    if not rows.numel():
        return []
    slopes = ca.jacobian(rows, ca.vertcat(expressions.x, inputs))
    places, out = _places(slopes), "h" if inputs.is_empty() else "g"
    arguments = f"model, x, {out}" if inputs.is_empty() else f"model, x, u, {out}"

    def write(k: int, i: int, value: str) -> str:
        return f"{out}[{i}] = {value}" if k == 0 else f"jacobian[{places[i][0]}, {places[i][1]}] = {value}"

    return [
        _kernel(expressions, name, arguments, [rows], write),
        _kernel(
            expressions, slopes_name, f"{arguments}, jacobian", [rows, slopes], write, before=["jacobian[:, :] = 0.0"]
        ),
    ]


def _horizon(expressions: Expressions) -> str:
    step = _places(ca.jacobian(expressions.step, _both(expressions)))
    nx, nh = expressions.x.numel(), expressions.rows.numel()
    scattered = [f"jacobian[{i}, {nx}] = values[{i}] - ahead[{i}]" for i in range(nx)]  # [A | e | B]
    scattered += [
        f"jacobian[{row}, {column if column < nx else column + 1}] = values[{nx + i}]"
        for i, (row, column) in enumerate(step)
    ]
    text = HORIZON.format(
        step_rows=_indices([row for row, _ in step]), step_columns=_indices([column for _, column in step]),
        scatter_step="\n    ".join(scattered),
    )  # fmt: skip
    if not nh:
        return text
    rows = _places(ca.jacobian(expressions.rows, expressions.x))
    scattered = [f"row[{i}] = values[{i}]" for i in range(nh)]
    scattered += [f"jacobian[{row}, {column}] = values[{nh + i}]" for i, (row, column) in enumerate(rows)]
    return text + HORIZON_ROWS.format(
        row_rows=_indices([row for row, _ in rows]), row_columns=_indices([column for _, column in rows]),
        scatter_rows="\n    ".join(scattered),
    )  # fmt: skip


def _indices(values: list[int]) -> str:
    return f"np.array({values}, dtype=np.int64)"


def _squares(cost: Expansion) -> int:
    """How many numbers the squares of a cost are expanded from."""
    return int(2 * cost.residuals.numel() + cost.slopes.nnz())


def _cost(expressions: Expressions, name: str, cost: Expansion, arguments: str) -> list[str]:
    convex, bent, count = _places(cost.convex), _places(cost.bent), cost.residuals.numel()
    by_rows = cost.slopes.T  # CasADi goes down the columns
    ends = np.cumsum([0, *np.bincount([row for _, row in _places(by_rows)], minlength=count)]).tolist()
    tables = (
        f"{name.upper()}_ENDS = {_indices(ends)}\n"
        f"{name.upper()}_COLUMNS = {_indices([column for column, _ in _places(by_rows)])}\n"
        f"{name.upper()}_CONVEX_ROWS = {_indices([row for row, _ in convex])}\n"
        f"{name.upper()}_CONVEX_COLUMNS = {_indices([column for _, column in convex])}"
    )

    def write(k: int, i: int, value: str) -> str:
        if k == 0:
            return f"gradient[{i}] = {value}"
        if k == 1:
            return f"hessian[{bent[i][0]}, {bent[i][1]}] = {value}"
        return f"model.squares[{_squares(cost) + i if k == 2 else i + (k - 3) * count}] = {value}"

    after = ["keep_positive(hessian, model.curvature)"] if bent else []
    if convex:
        places = f"{name.upper()}_CONVEX_ROWS, {name.upper()}_CONVEX_COLUMNS"
        after += [f"add_entries(model.squares, {_squares(cost)}, {places}, hessian)"]
    if count:
        after += [f"add_squares(model.squares, {name.upper()}_ENDS, {name.upper()}_COLUMNS, gradient, hessian)"]
    squares = [ca.densify(cost.residuals), cost.weights, by_rows]
    results = [ca.densify(cost.gradient), cost.bent, cost.convex, *squares]
    return [
        tables,
        _kernel(expressions, name, arguments, [cost.value], lambda k, i, v: f"return {v}", returns=" -> float"),
        _kernel(
            expressions,
            f"expand_{name}",
            f"{arguments}, gradient, hessian",
            results,
            write,
            ["hessian[:, :] = 0.0"],
            after,
        ),
    ]


def _places(matrix: Any) -> list[tuple[int, int]]:
    """Row and column of every nonzero, in CasADi's order."""
    rows, columns = matrix.sparsity().get_triplet()
    return list(zip(rows, columns, strict=True))


def _arguments(expressions: Expressions) -> dict[str, Any]:
    return {
        "x": expressions.x,
        "u": expressions.u,
        "h": expressions.time_step,
        "p": expressions.parameters,
        "q": expressions.node_parameters,
    }


def _kernel(
    expressions: Expressions, name: str, arguments: str, results: list[Any], write: Any, before: Sequence[str] = (),
    after: Sequence[str] = (), returns: str = "",
) -> str:  # fmt: skip
    """A kernel of one node; with lines that are not straight before or after, these around the formula."""
    places = {"x": "x[{}]", "u": "u[{}]", "h": "model.time_step", "p": "model.parameters[{}]", "q": "model.q[{}]"}
    lines = printed(name, _arguments(expressions), results, lambda symbol, i: places[symbol].format(i), write)
    body = "\n    ".join(lines)
    if not (before or after):
        return f"{_decorators(expressions, name)}def {name}({arguments}){returns}:\n    {body}"
    around = "\n    ".join([*before, f"{name}_formula({arguments})", *after])
    formula = f"@straight\ndef {name}_formula({arguments}):\n    {body}\n\n\n"
    return f"{formula}{_decorators(expressions, name, 'kernel')}def {name}({arguments}):\n    {around}"


def _decorators(expressions: Expressions, name: str, kind: str = "straight") -> str:
    owners = ("Model", "Node") if _has_nodes(expressions) else ("Model",)
    return "".join(f"@functions.implement(functions.{name}, {owner})\n" for owner in owners) + f"@{kind}\n"


def _lanes(expressions: Expressions, name: str, arguments: str, results: list[Any]) -> str:
    """A kernel of nodes side by side: expressions nonzeros of expressions results, one after the other."""
    offsets = [sum(result.nnz() for result in results[:k]) for k in range(len(results))]
    places = {"h": "model.time_step", "p": "model.parameters[{}]"}

    def read(symbol: str, i: int) -> str:
        return places[symbol].format(i) if symbol in places else f"get({symbol}, {i}, WIDTH)"

    def write(k: int, i: int, value: str) -> str:
        return f"put(out, {offsets[k] + i}, zero(WIDTH) + {value})"

    lines = printed(name, _arguments(expressions), results, read, write)
    return f"@straight\ndef {name}({arguments}):\n    " + "\n    ".join(lines)
