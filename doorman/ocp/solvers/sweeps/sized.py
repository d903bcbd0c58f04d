"""What is compiled for a problem's sizes: a node's elimination, and products and bounds of its rows.

Their loops over states and inputs are unrolled, and their sums stay in registers. All other kernels take the sizes as numbers and
are compiled once for all problems; they call these through a table in the workspace.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numba
from numba.core import types

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.numba_types.function_tables import FunctionTable, taught, wrap
from doorman.numba_types.handles import Handle, HandleType
from doorman.numba_types.lanes import load, store
from doorman.numba_types.matrix_rows import multiply_rows
from doorman.ocp.solvers.memory.parts import Sizes
from doorman.ocp.solvers.sweeps.node_bounds import mark_bounds
from doorman.ocp.solvers.sweeps.node_elimination import eliminate_inputs

_ROW, _MATRIX = types.Array(types.float64, 1, "C"), types.Array(types.float64, 2, "C")
_entries: list[tuple[Any, tuple[Any, ...]]] = []
"""Kernels of the table, and numba's types of what they take after the workspace."""


class Shape(NamedTuple):
    """Sizes as lengths of tuples, which are part of the type."""

    states: tuple[int, ...]
    inputs: tuple[int, ...]
    integrators: tuple[int, ...]
    narrow: tuple[int, ...]
    wide: tuple[int, ...]


class SizedTable(FunctionTable):
    """The functions of this module for one problem's sizes.

    Args:
        shape: The sizes.
        work: numba's type of the workspace.
    """

    __slots__ = ("_handle", "_work")

    def __init__(self, shape: Shape, work: Any) -> None:
        self._handle, self._work = Handle(shape), work
        taken = self._handle._numba_type_, types.int64, HandleType(work)
        super().__init__(self._handle.address, [entry.address((*taken, *others), wrap) for entry, others in _entries])

    def __reduce__(self) -> tuple[Any, ...]:
        return SizedTable, (self._handle.content, self._work)


def sized_table(sizes: Sizes, workspace: Any) -> SizedTable:
    """Table for a workspace's sizes; compiled, or loaded from the cache."""
    return SizedTable(shape_of(sizes), numba.typeof(workspace))  # type: ignore[no-untyped-call]


def shape_of(sizes: Sizes) -> Shape:
    """Sizes as types."""
    return Shape(*((0,) * getattr(sizes, name) for name in Shape._fields))


def _entry(*others: Any, returns: Any = types.void) -> Callable[[Callable[..., Any]], Any]:
    """A kernel of sizes, node and workspace: what kernels call in its place takes the table, the node and the workspace."""

    def enter(function: Callable[..., Any]) -> Any:
        _entries.append((kernel(function), others))
        return taught(function.__name__, len(_entries) - 1, returns)

    return enter


@_entry(returns=types.boolean)
def eliminate(shape: Any, k: int, work: Any) -> bool:
    """Value function of node k from that of node k + 1, the policy between them, and sums from node k on.

    See `node_elimination`.
    """
    node, policy, nx = work.node, work.policy, len(shape.states)
    positive = eliminate_inputs(
        shape, k, work.weights.time_step, work.linear.jacobians, node.value, node.base_x, node.base_u,
        policy.gains, policy.factors, policy.values, node.rows, node.scaled,
    )  # fmt: skip
    decrease, costate = policy.decreases[k + 1], policy.costates[k + 1]
    for a in range(len(shape.inputs)):
        decrease += node.rows[a, nx] * node.scaled[a, nx]
    for i in range(nx):
        costate = max(costate, abs(node.value[i, nx]))
    policy.decreases[k], policy.costates[k] = decrease, costate
    return positive  # type: ignore[no-any-return]


@_entry()
def set_slopes(shape: Any, k: int, work: Any) -> None:
    """Gradient of the cost's diagonals at node k, into `node.base_x` and `node.base_u`."""
    base_x, base_u, weights, nx = work.node.base_x, work.node.base_u, work.weights, len(shape.states)
    states, inputs = work.nominal.states, work.nominal.inputs
    for i in range(nx):
        base_x[i, nx] = weights.state[i] * (states[k, i] - weights.state_goal[i])
    for i in range(len(shape.inputs)):
        base_u[i, nx] = weights.input[i] * (inputs[k, i] - weights.input_goal[i])


@_entry(_ROW, types.float64)
def add_square(shape: Any, k: int, work: Any, row: Array, weight: float) -> None:
    """Add a row's square, weighted, to the value function at hand."""
    value = work.node.value
    for a in range(len(shape.states)):
        scale = weight * row[a]
        store(value, (a, 0), load(value, (a, 0), shape.narrow) + scale * load(row, 0, shape.narrow))


@_entry()
def multiply_gains(shape: Any, k: int, work: Any) -> None:
    """Input part of `node.step` by the policy of node k."""
    step = work.node.step
    multiply_rows(work.policy.gains, k, shape.inputs, shape.narrow, step, step, len(shape.states) + 1)


@_entry()
def multiply_dynamics(shape: Any, k: int, work: Any) -> None:
    """State part of `node.step` by the linearised dynamics of node k."""
    step = work.node.step
    multiply_rows(work.linear.jacobians, k, shape.states, shape.wide, step, step, 0)


@_entry(returns=types.float64)
def step_node(shape: Any, k: int, work: Any) -> float:
    """Step of node k by policy and linearised dynamics into the trial trajectory, with its rows: its largest weighted change."""
    nx, nu, nh, ng = len(shape.states), len(shape.inputs), work.sizes.rows, work.sizes.input_rows
    nominal, trial, step, linear, largest = work.nominal, work.trial, work.node.step, work.linear, 0.0
    step[nx] = 1.0
    for i in range(nu):
        step[nx + 1 + i] = 0.0
    multiply_rows(work.policy.gains, k, shape.inputs, shape.narrow, step, step, nx + 1)
    for i in range(nu):
        largest = max(largest, work.weights.metric[i] * abs(step[nx + 1 + i]))
        trial.inputs[k, i] = nominal.inputs[k, i] + step[nx + 1 + i]
    if ng > 0:
        step[nx] = 0.0
        rows = trial.input_rows.reshape(-1)
        multiply_rows(linear.input_row_jacobians, k, ng, shape.wide, step, rows, k * ng)
        step[nx] = 1.0
        for i in range(ng):
            trial.input_rows[k, i] += nominal.input_rows[k, i]
    multiply_rows(linear.jacobians, k, shape.states, shape.wide, step, step, 0)
    for i in range(nx):
        trial.states[k + 1, i] = nominal.states[k + 1, i] + step[i]
    if nh > 0:
        multiply_rows(linear.row_jacobians, k, nh, shape.narrow, step, trial.rows.reshape(-1), k * nh)
        for i in range(nh):
            trial.rows[k, i] += nominal.rows[k, i]
    return largest


@_entry(types.float64)
def apply_policy(shape: Any, k: int, work: Any, scale: float) -> None:
    """Input of node k of the trial trajectory by the policy, inside its bounds."""
    nx, nu = len(shape.states), len(shape.inputs)
    nominal, trial, limits, step = work.nominal, work.trial, work.limits, work.node.step
    for j in range(nx):
        step[j] = trial.states[k, j] - nominal.states[k, j]
    step[nx] = scale
    for a in range(nu):
        step[nx + 1 + a] = 0.0
    multiply_rows(work.policy.gains, k, shape.inputs, shape.narrow, step, step, nx + 1)
    for a in range(nu):
        total = nominal.inputs[k, a] + step[nx + 1 + a]
        if work.sizes.input_bounds > 0:
            total = min(max(total, limits.input_lower[a]), limits.input_upper[a])
        trial.inputs[k, a] = total


@_entry(_MATRIX, _MATRIX, returns=types.float64)
def diagonal_cost(shape: Any, k: int, work: Any, states: Array, inputs: Array) -> float:
    """Cost of the diagonals along a trajectory."""
    weights, n, total = work.weights, inputs.shape[0], 0.0
    for k in range(n):
        for i in range(len(shape.states)):
            error = states[k, i] - weights.state_goal[i]
            total += weights.state[i] * error * error
        for i in range(len(shape.inputs)):
            error = inputs[k, i] - weights.input_goal[i]
            total += weights.input[i] * error * error
    for i in range(len(shape.states)):
        error = states[n, i] - weights.state_goal[i]
        total += weights.terminal[i] * error * error
    return 0.5 * total


@_entry(_ROW, _ROW, types.float64, types.float64, returns=types.boolean)
def mark_node(shape: Any, k: int, work: Any, state: Array, inputs: Array, stiff: float, penalty: float) -> bool:
    """Active bounds of state k + 1 and of input k, and their multipliers; counted in `active`. Whether the set has changed."""
    limits, active, multipliers, proposal, changed = work.limits, work.active, work.multipliers, work.proposal, False
    if work.sizes.state_bounds > 0:
        count, flipped = mark_bounds(
            k, shape.states, state, limits.state_lower, limits.state_upper, multipliers.states, stiff, active.states,
            proposal.states,
        )  # fmt: skip
        active.state_count[k] += count
        changed |= flipped
    if work.sizes.input_bounds > 0:
        count, flipped = mark_bounds(
            k, shape.inputs, inputs, limits.input_lower, limits.input_upper, multipliers.inputs, penalty, active.inputs,
            proposal.inputs,
        )  # fmt: skip
        active.input_count[k] += count
        changed |= flipped
    return changed
