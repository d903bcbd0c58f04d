"""Text of the kernels of second derivatives: the Hessian of the Lagrangian, nodes side by side, and at the last node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca

from doorman.ocp.kernels.printed.printing import printed
from doorman.ocp.problem.expressions import Expressions

_TEXT = """
CURVE_ROWS = {rows}
CURVE_COLUMNS = {columns}


@straight
def curve_lanes(model, x, u, q, costates, prices, out):
    {lanes}


@straight
def curve_end(model, x, prices, gradient, hessian):
    {end}


@functions.implement(functions.curve_horizon, Model)
@kernel
def curve_horizon(model, states, inputs, costates, prices, counts, gradients, hessians):
    n = inputs.shape[0]
    for first in range(0, n, LANES):
        gather(states, first, n, model.x_lanes)
        gather(inputs, first, n, model.u_lanes)
        gather(model.node_parameters, first, n, model.q_lanes)
        gather(costates, first, n, model.costates)
        gather(prices, first, n, model.prices)
        curve_lanes(model, model.x_lanes, model.u_lanes, model.q_lanes, model.costates, model.prices, model.out)
        scatter_curvature(model.out, first, n, CURVE_ROWS, CURVE_COLUMNS, gradients, hessians)
    gradients[n, :] = 0.0
    hessians[n, :, :] = 0.0
    curve_end(functions.at_node(model, n), states[n], prices[n], gradients[n], hessians[n])
"""


def curvature_text(expressions: Expressions) -> tuple[str, int]:
    """Kernels of `curve_horizon`, and how many numbers of a node they write."""
    costates, prices, stage, end = _lagrangian(expressions)
    z = ca.vertcat(expressions.x, expressions.u)
    stage_cost, end_cost = (
        ca.SX(0) if each is None else each.value for each in (expressions.stage_cost, expressions.end_cost)
    )
    curvature, at_end = (ca.SX(ca.tril(ca.hessian(each, by)[0])) for each, by in ((stage, z), (end, expressions.x)))
    rows, columns = _places(curvature)
    end_rows, end_columns = _places(at_end)
    symbols = {
        "x": expressions.x, "u": expressions.u, "h": expressions.time_step, "p": expressions.parameters,
        "q": expressions.node_parameters, "costates": costates, "prices": prices,
    }  # fmt: skip
    numbers = {"h": "model.time_step", "p": "model.parameters[{}]"}

    def write_end(k: int, i: int, value: str) -> str:
        if k == 0:
            return f"gradient[{i}] = {value}"
        row, column = end_rows[i], end_columns[i]
        return f"hessian[{row}, {column}] = hessian[{column}, {row}] = {value}"

    lanes = printed(
        "curve_horizon", symbols, [ca.densify(ca.gradient(stage_cost, z)), curvature],
        lambda name, i: numbers[name].format(i) if name in numbers else f"get({name}, {i}, WIDTH)",
        lambda k, i, value: f"put(out, {i + k * z.numel()}, zero(WIDTH) + {value})",
    )  # fmt: skip
    last = printed(
        "curve_horizon", symbols, [ca.densify(ca.gradient(end_cost, expressions.x)), at_end],
        _reader({**numbers, "q": "model.q[{}]"}), write_end,
    )  # fmt: skip
    text = _TEXT.format(
        rows=f"np.array({rows}, dtype=np.int64)", columns=f"np.array({columns}, dtype=np.int64)",
        lanes="\n    ".join(lanes), end="\n    ".join(last),
    )  # fmt: skip
    return text, int(z.numel() + curvature.nnz())


def _places(matrix: Any) -> tuple[list[int], list[int]]:
    """Rows and columns of the nonzeros."""
    rows, columns = matrix.sparsity().get_triplet()
    return rows, columns


def _reader(places: dict[str, str]) -> Callable[[str, int], str]:
    return lambda name, i: places.get(name, name + "[{}]").format(i)


def _lagrangian(expressions: Expressions) -> tuple[Any, Any, Any, Any]:
    """Symbols p and y, the Lagrangian ℓ + pᵀf + yᵀ(h, h_N, g) of a node, and what counts of it at the last one."""
    rows, end_rows, input_rows = expressions.rows, expressions.end_rows, expressions.input_rows
    nh, nt = rows.numel(), end_rows.numel()
    costates, prices = ca.SX.sym("p", expressions.x.numel()), ca.SX.sym("y", nh + nt + input_rows.numel())
    of_state = _sum(prices[:nh], rows)
    stage = of_state + _sum(costates, expressions.step) + _sum(prices[nh + nt :], input_rows)
    end = of_state + _sum(prices[nh : nh + nt], end_rows)
    if expressions.stage_cost is not None and expressions.end_cost is not None:
        stage, end = stage + expressions.stage_cost.value, end + expressions.end_cost.value
    return costates, prices, stage, end


def _sum(prices: Any, rows: Any) -> Any:
    """yᵀh."""
    return ca.dot(prices, rows) if rows.numel() else ca.SX(0)


def prices_of(expressions: Expressions) -> int:
    """Number of multipliers of rows that the kernels read: those of h, h_N and g."""
    return int(expressions.rows.numel() + expressions.end_rows.numel() + expressions.input_rows.numel())
