"""Text of the module that computes one problem's expressions: a model type and its kernels."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from doorman.ocp.kernels.printed.kernel_text import KernelText, indices, places, tables
from doorman.ocp.kernels.printed.module_templates import (
    CURVATURE,
    HEAD,
    HORIZON,
    HORIZON_ROWS,
    LINEARIZE_ROWS,
    LINEARIZE_STEP,
    NODE,
)
from doorman.ocp.problem.expressions import Expansion, Expressions, integrators_of


def module_text(expressions: Expressions, second_derivatives: bool = False) -> str:
    """The module's text: the same for the same expressions."""
    kernels, empty = KernelText(expressions), ca.SX(0, 1)
    curvature, outputs = _curvature(expressions) if second_derivatives else ([], 0)
    parts = [_head(expressions, outputs), *([NODE] if kernels.has_nodes else []), *_step(expressions, kernels)]
    parts += _state_rows(expressions, kernels)
    parts += _rows(kernels, "input_constraints", "g", expressions.input_rows, expressions.x, expressions.u)
    parts += _rows(kernels, "end_constraints", "h", expressions.end_rows, expressions.x, empty)
    if expressions.stage_cost is not None and expressions.end_cost is not None:
        parts += _cost(kernels, "stage_cost", expressions.stage_cost, "model, x, u")
        parts += _cost(kernels, "end_cost", expressions.end_cost, "model, x")
    parts += [_horizon(expressions), *curvature]
    return "\n\n\n".join(part.strip("\n") for part in parts) + "\n"


def _head(expressions: Expressions, outputs: int) -> str:
    x, u, p, q = expressions.x, expressions.u, expressions.parameters, expressions.node_parameters
    bent = 0 if expressions.stage_cost is None else x.numel() + u.numel()
    costs = [each for each in (expressions.stage_cost, expressions.end_cost) if each]
    squares = bent + max((_squares(each) + int(each.convex.nnz()) for each in costs), default=0)
    largest = max(_outputs(expressions.step, ca.vertcat(x, u)), _outputs(expressions.rows, x), outputs)
    symbols = {
        name: ", ".join(str(symbol) for symbol in ca.symvar(each)) or "none"
        for name, each in (("x", x), ("u", u), ("p", p), ("q", q))
    }
    rows = tuple(each.numel() for each in (expressions.rows, expressions.input_rows, expressions.end_rows))
    return HEAD.format(
        nx=x.numel(), nu=u.numel(), nq=q.numel(), outputs=largest, bent=bent, squares=squares, prices=sum(rows),
        rows=rows, integrators=integrators_of(expressions), names=expressions.names,
        equalities=expressions.equalities, **symbols,
    )  # fmt: skip


def _outputs(values: Any, z: Any) -> int:
    """How many numbers an expression and its Jacobian have."""
    return int(values.numel() + ca.jacobian(values, z).nnz())


def _step(expressions: Expressions, kernels: KernelText) -> list[str]:
    slopes = ca.jacobian(expressions.step, ca.vertcat(expressions.x, expressions.u))
    spread = _spread_node(kernels)
    return [
        kernels.formula("rate", "model, x, u, out", [expressions.rate], lambda k, i, v: f"out[{i}] = {v}"),
        kernels.node("step", "model, x, u, out", [expressions.checked_step], lambda k, i, v: f"out[{i}] = {v}"),
        kernels.lanes("step_lanes", "model, x, u, q, out", [expressions.checked_step, slopes]),
        kernels.implemented("linearize_step", LINEARIZE_STEP.format(spread=spread)),
    ]


def _state_rows(expressions: Expressions, kernels: KernelText) -> list[str]:
    """Kernels of h, where there are any."""
    rows = expressions.rows
    if not rows.numel():
        return []
    return [
        kernels.node("constrain", "model, x, h", [rows], lambda k, i, v: f"h[{i}] = {v}"),
        kernels.lanes("rows_lanes", "model, x, q, out", [rows, ca.jacobian(rows, expressions.x)]),
        kernels.lanes("row_values_lanes", "model, x, q, out", [rows]),
        kernels.implemented("linearize_constraints", LINEARIZE_ROWS.format(spread=_spread_node(kernels))),
    ]


def _spread_node(kernels: KernelText) -> str:
    return "\n    spread(model.q, model.q_lanes)" if kernels.has_nodes else ""


def _rows(kernels: KernelText, name: str, out: str, rows: Any, x: Any, inputs: Any) -> list[str]:
    """Kernels of g or h_N, where there are any."""
    if not rows.numel():
        return []
    slopes = ca.jacobian(rows, ca.vertcat(x, inputs))
    at, arguments = places(slopes), f"model, x, {out}" if inputs.is_empty() else f"model, x, u, {out}"

    def write(k: int, i: int, value: str) -> str:
        return f"{out}[{i}] = {value}" if k == 0 else f"jacobian[{at[i][0]}, {at[i][1]}] = {value}"

    whole = f"{arguments}, jacobian"
    return [
        kernels.node(f"constrain_{name.split('_')[0]}", arguments, [rows], write),
        kernels.around(f"linearize_{name}", whole, [rows, slopes], write, "jacobian[:, :] = 0.0"),
    ]


def _horizon(expressions: Expressions) -> str:
    step = ca.jacobian(expressions.step, ca.vertcat(expressions.x, expressions.u))
    nx, nh = expressions.x.numel(), expressions.rows.numel()
    scattered = [f"jacobian[{i}, {nx}] = values[{i}] - ahead[{i}]" for i in range(nx)]  # [A | e | B]
    scattered += [
        f"jacobian[{row}, {column if column < nx else column + 1}] = values[{nx + i}]"
        for i, (row, column) in enumerate(places(step))
    ]
    text = HORIZON.format(tables=tables("STEP", step), scatter_step="\n    ".join(scattered))
    if not nh:
        return text
    rows = ca.jacobian(expressions.rows, expressions.x)
    scattered = [f"row[{i}] = values[{i}]" for i in range(nh)]
    scattered += [f"jacobian[{row}, {column}] = values[{nh + i}]" for i, (row, column) in enumerate(places(rows))]
    return text + HORIZON_ROWS.format(tables=tables("ROW", rows), scatter_rows="\n    ".join(scattered))


def _squares(cost: Expansion) -> int:
    """How many numbers the squares of a cost are expanded from."""
    return int(2 * cost.residuals.numel() + cost.slopes.nnz())


def _cost(kernels: KernelText, name: str, cost: Expansion, arguments: str) -> list[str]:
    bent, count, constants = places(cost.bent), cost.residuals.numel(), name.upper()
    by_rows = cost.slopes.T  # CasADi goes down the columns
    nonzeros = places(by_rows)
    ends = np.cumsum([0, *np.bincount([column for _, column in nonzeros], minlength=count)]).tolist()

    def write(k: int, i: int, value: str) -> str:
        if k == 0:
            return f"gradient[{i}] = {value}"
        if k == 1:
            return f"hessian[{bent[i][0]}, {bent[i][1]}] = {value}"
        return f"model.squares[{_squares(cost) + i if k == 2 else i + (k - 3) * count}] = {value}"

    after = ["keep_positive(hessian, model.curvature)"] if bent else []
    if cost.convex.nnz():
        at = f"{constants}_CONVEX_ROWS, {constants}_CONVEX_COLUMNS"
        after += [f"add_entries(model.squares, {_squares(cost)}, {at}, hessian)"]
    if count:
        after += [f"add_squares(model.squares, {constants}_ENDS, {constants}_COLUMNS, gradient, hessian)"]
    results = [ca.densify(cost.gradient), cost.bent, cost.convex, ca.densify(cost.residuals), cost.weights, by_rows]
    own = [
        f"{constants}_ENDS = {indices(ends)}", f"{constants}_COLUMNS = {indices([row for row, _ in nonzeros])}",
        tables(f"{constants}_CONVEX", cost.convex),
    ]  # fmt: skip
    return [
        "\n".join(own),
        kernels.node(name, arguments, [cost.value], lambda k, i, v: f"return {v}", " -> float"),
        kernels.around(
            f"expand_{name}", f"{arguments}, gradient, hessian", results, write, "hessian[:, :] = 0.0", after
        ),
    ]


def _curvature(expressions: Expressions) -> tuple[list[str], int]:
    """Kernels of second derivatives of the Lagrangian ℓ + pᵀf + yᵀ(h, h_N, g), and how many numbers of a node they write."""
    x, rows, end_rows, input_rows = expressions.x, expressions.rows, expressions.end_rows, expressions.input_rows
    nh, nt, z = rows.numel(), end_rows.numel(), ca.vertcat(x, expressions.u)
    costates, prices = ca.SX.sym("p", x.numel()), ca.SX.sym("y", nh + nt + input_rows.numel())
    stage_cost, end_cost = (
        ca.SX(0) if each is None else each.value for each in (expressions.stage_cost, expressions.end_cost)
    )
    of_state = _sum(prices[:nh], rows)
    stage = of_state + _sum(costates, expressions.step) + _sum(prices[nh + nt :], input_rows) + stage_cost
    end = of_state + _sum(prices[nh : nh + nt], end_rows) + end_cost
    curvature, at_end = (ca.SX(ca.tril(ca.hessian(each, by)[0])) for each, by in ((stage, z), (end, x)))
    kernels, end_places = KernelText(expressions, costates=costates, prices=prices), places(at_end)

    def write_end(k: int, i: int, value: str) -> str:
        if k == 0:
            return f"gradient[{i}] = {value}"
        row, column = end_places[i]
        return f"hessian[{row}, {column}] = hessian[{column}, {row}] = {value}"

    results = [ca.densify(ca.gradient(stage_cost, z)), curvature]
    parts = [
        tables("CURVE", curvature), kernels.lanes("curve_lanes", "model, x, u, q, costates, prices, out", results),
        kernels.formula("curve_end", "model, x, prices, gradient, hessian",
                        [ca.densify(ca.gradient(end_cost, x)), at_end], write_end),
        CURVATURE,
    ]  # fmt: skip
    return parts, int(z.numel() + curvature.nnz())


def _sum(prices: Any, rows: Any) -> Any:
    """yᵀh."""
    return ca.dot(prices, rows) if rows.numel() else ca.SX(0)
