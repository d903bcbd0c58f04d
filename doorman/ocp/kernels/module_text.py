"""Text of the module that computes one problem's expressions: a model type and its kernels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import casadi as ca

from doorman.ocp.kernels.curvature_text import curvature_text, prices_of
from doorman.ocp.kernels.operations import IMPORTS
from doorman.ocp.kernels.printing import printed
from doorman.ocp.problem.expressions import Expansion, Expressions

_HEAD = '''"""Kernels of a problem with {nx} states and {nu} inputs, printed from CasADi expressions.

States x: {x}. Inputs u: {u}. Parameters p: {p}. Parameters q of each node: {q}.
"""

from typing import NamedTuple

import numpy as np

from doorman.compilation import kernel
{imports}from doorman.ocp.kernels import functions
from doorman.ocp.kernels.loading import remade
from doorman.ocp.kernels.runtime import (
    LANES,
    WIDTH,
    gather,
    keep_positive,
    scatter_curvature,
    scatter_rows,
    scatter_slopes,
    scatter_step,
)


class Model(NamedTuple):
    """Numbers that change without compiling, and memory of the kernels."""

    time_step: float
    parameters: np.ndarray
    node_parameters: np.ndarray
    x: np.ndarray
    u: np.ndarray
    q: np.ndarray
    out: np.ndarray
    curvature: np.ndarray
    costates: np.ndarray
    prices: np.ndarray

    @classmethod
    def of(cls, time_step, parameters, node_parameters):
        """Numbers with fresh memory."""
        x, u, q = np.zeros(({nx}, LANES)), np.zeros(({nu}, LANES)), np.zeros(({nq}, LANES))
        out, curvature = np.zeros(({outputs}, LANES)), np.zeros(({bent}, {bent}))
        costates, prices = np.zeros(({nx}, LANES)), np.zeros(({prices}, LANES))
        return cls(float(time_step), parameters, node_parameters, x, u, q, out, curvature, costates, prices)

    def __reduce__(self):
        return remade, (TEXT, self.time_step, self.parameters, self.node_parameters)


class Node(NamedTuple):
    """What the kernels of one node need; `q` are its parameters."""

    time_step: float
    parameters: np.ndarray
    q: np.ndarray
    curvature: np.ndarray


@functions.implement(functions.at_node, Model)
def at_node(model, k):
    return Node(model.time_step, model.parameters, model.node_parameters[k], model.curvature)
'''

_MOST_LINES = 10_000
"""Longer kernels of second derivatives take minutes to compile."""

_HORIZON = """
STEP_ROWS = {step_rows}
STEP_COLUMNS = {step_columns}


@functions.implement(functions.linearize_horizon, Model)
@kernel
def linearize_horizon(model, states, inputs, jacobians, rows, row_jacobians):
    n = inputs.shape[0]
    for first in range(0, n, LANES):
        gather(states, first, n, model.x)
        gather(inputs, first, n, model.u)
        gather(model.node_parameters, first, n, model.q)
        step_lanes(model, model.x, model.u, model.q, model.out)
        scatter_step(model.out, first, states, STEP_ROWS, STEP_COLUMNS, jacobians)
"""

_HORIZON_ROWS = """        gather(states, first + 1, n + 1, model.x)
        gather(model.node_parameters, first + 1, n + 1, model.q)
        rows_lanes(model, model.x, model.q, model.out)
        scatter_rows(model.out, first, rows)
        scatter_slopes(model.out, first, ROW_ROWS, ROW_COLUMNS, rows, row_jacobians)


ROW_ROWS = {row_rows}
ROW_COLUMNS = {row_columns}


@functions.implement(functions.constrain_horizon, Model)
@kernel
def constrain_horizon(model, states, rows):
    n = rows.shape[0]
    for first in range(0, n, LANES):
        gather(states, first + 1, n + 1, model.x)
        gather(model.node_parameters, first + 1, n + 1, model.q)
        row_values_lanes(model, model.x, model.q, model.out)
        scatter_rows(model.out, first, rows)
"""


def module_text(expressions: Expressions, second_derivatives: bool | None = False) -> str:
    """The module's text: the same for the same expressions.

    Args:
        expressions: Of one problem.
        second_derivatives: Print the Hessian of the Lagrangian, too; None: unless that takes very long to compile.

    Returns:
        Python.

    Raises:
        SolverError: if an operation has no translation.
    """
    curvature, outputs = ("", 0) if second_derivatives is False else curvature_text(expressions)
    if second_derivatives is None and curvature.count("\n") > _MOST_LINES:
        curvature, outputs = "", 0
    parts = [_head(expressions, outputs), *_step(expressions)]
    parts += _rows(expressions, "constrain", "linearize_constraints", expressions.rows, ca.SX(0, 1))
    parts += _rows(expressions, "constrain_input", "linearize_input_constraints", expressions.input_rows, expressions.u)
    parts += _rows(expressions, "constrain_end", "linearize_end_constraints", expressions.end_rows, ca.SX(0, 1))
    if expressions.stage_cost is not None and expressions.end_cost is not None:
        parts += _cost(expressions, "stage_cost", expressions.stage_cost, "model, x, u")
        parts += _cost(expressions, "end_cost", expressions.end_cost, "model, x")
    parts += [*_horizon(expressions), *([curvature] if curvature else [])]
    return "\n\n\n".join(part.strip("\n") for part in parts) + "\n"


def _head(expressions: Expressions, outputs: int) -> str:
    x, u, p, q = expressions.x, expressions.u, expressions.parameters, expressions.node_parameters
    bent = 0 if expressions.stage_cost is None else x.numel() + u.numel()
    largest = max(_outputs(expressions.step, _both(expressions)), _outputs(expressions.rows, x), outputs)
    names = {
        name: ", ".join(str(symbol) for symbol in ca.symvar(symbols)) or "none"
        for name, symbols in (("x", x), ("u", u), ("p", p), ("q", q))
    }
    return _HEAD.format(
        nx=x.numel(), nu=u.numel(), nq=q.numel(), outputs=largest, bent=bent, prices=prices_of(expressions),
        imports=IMPORTS, **names,
    )  # fmt: skip


def _both(expressions: Expressions) -> Any:
    return ca.vertcat(expressions.x, expressions.u)


def _outputs(values: Any, z: Any) -> int:
    """How many numbers an expression and its Jacobian have."""
    return int(values.numel() + ca.jacobian(values, z).nnz())


def _step(expressions: Expressions) -> list[str]:
    slopes = ca.jacobian(expressions.step, _both(expressions))
    places = _places(slopes)
    return [
        _kernel(expressions, "step", "model, x, u, out", [expressions.step], lambda k, i, v: f"out[{i}] = {v}"),
        _kernel(
            expressions, "linearize_step", "model, x, u, jacobian", [slopes],
            lambda k, i, v: f"jacobian[{places[i][0]}, {places[i][1]}] = {v}", before=["jacobian[:, :] = 0.0"],
        ),
        _lanes(expressions, "step_lanes", "model, x, u, q, out", [expressions.step, slopes]),
    ]  # fmt: skip


def _rows(expressions: Expressions, name: str, slopes_name: str, rows: Any, inputs: Any) -> list[str]:
    """Kernels of h, g or h_N, where there are any."""
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


def _horizon(expressions: Expressions) -> list[str]:
    step = _places(ca.jacobian(expressions.step, _both(expressions)))
    nx, rows = expressions.x.numel(), _places(ca.jacobian(expressions.rows, expressions.x))
    columns = [column if column < nx else column + 1 for _, column in step]  # [A | e | B]
    text = _HORIZON.format(step_rows=_indices([row for row, _ in step]), step_columns=_indices(columns))
    if not expressions.rows.numel():
        return [text]
    slopes = ca.jacobian(expressions.rows, expressions.x)
    text += _HORIZON_ROWS.format(
        row_rows=_indices([row for row, _ in rows]), row_columns=_indices([column for _, column in rows])
    )
    return [
        _lanes(expressions, "rows_lanes", "model, x, q, out", [expressions.rows, slopes]),
        _lanes(expressions, "row_values_lanes", "model, x, q, out", [expressions.rows]),
        text,
    ]


def _indices(values: list[int]) -> str:
    return f"np.array({values}, dtype=np.int64)"


def _cost(expressions: Expressions, name: str, cost: Expansion, arguments: str) -> list[str]:
    convex, bent = _places(cost.convex), _places(cost.bent)

    def write(k: int, i: int, value: str) -> str:
        if k == 0:
            return f"gradient[{i}] = {value}"
        return f"hessian[{bent[i][0]}, {bent[i][1]}] = {value}" if k == 1 else f"h{i} = {value}"

    after = ["keep_positive(hessian, model.curvature)"] if bent else []
    after += [f"hessian[{row}, {column}] += h{i}" for i, (row, column) in enumerate(convex)]
    results = [ca.densify(cost.gradient), cost.bent, cost.convex]
    return [
        _kernel(expressions, name, arguments, [cost.value], lambda k, i, v: f"return {v}"),
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
    after: Sequence[str] = (),
) -> str:  # fmt: skip
    """A kernel of one node."""
    places = {"x": "x[{}]", "u": "u[{}]", "h": "model.time_step", "p": "model.parameters[{}]", "q": "model.q[{}]"}
    lines = printed(name, _arguments(expressions), results, lambda symbol, i: places[symbol].format(i), write)
    body = "\n    ".join([*before, *lines, *after])
    decorators = (
        f"@functions.implement(functions.{name}, Model)\n@functions.implement(functions.{name}, Node)\n@kernel\n"
    )
    return f"{decorators}def {name}({arguments}):\n    {body}"


def _lanes(expressions: Expressions, name: str, arguments: str, results: list[Any]) -> str:
    """A kernel of nodes side by side: expressions nonzeros of expressions results, one after the other."""
    offsets = [sum(result.nnz() for result in results[:k]) for k in range(len(results))]
    places = {"h": "model.time_step", "p": "model.parameters[{}]"}

    def read(symbol: str, i: int) -> str:
        return places[symbol].format(i) if symbol in places else f"get({symbol}, {i}, WIDTH)"

    def write(k: int, i: int, value: str) -> str:
        return f"put(out, {offsets[k] + i}, zero(WIDTH) + {value})"

    lines = printed(name, _arguments(expressions), results, read, write)
    return f"@kernel\ndef {name}({arguments}):\n    " + "\n    ".join(lines)
