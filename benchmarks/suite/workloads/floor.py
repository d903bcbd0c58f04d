"""Distance to the floor: the operations that one iteration cannot do without, at the speed at which this machine multiplies.

Counted for the problem's structure: entries of A, B and h_x that are always zero cost nothing. What is left out, and keeps any
code from getting there: chains of dependent roots and divisions, loads and stores, the shuffles between rows and registers.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from typing import Any

import casadi as ca
import numba
from llvmlite import ir
from numba.core import cgutils, types

from doorman.numba_types.lanes import builtin
from suite.expressions import constraint_function, step_function
from suite.session import Session
from suite.task import Task
from suite.tasks import paper

DIVISION, TRIGONOMETRY = 4.0, 16.0
"""What a division or root, and a sine, cosine or tangent, count for: multiplications and additions that take as long as the
best vectorised ones."""

_WIDTH, _ACCUMULATORS, _TURNS = 8, 6, 4_000_000  # more would not fit the registers of AVX2


def measure(session: Session) -> dict[str, Any]:
    """Operations of one iteration of the paper's task, and the machine's peak on the benchmark's core."""
    available = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {session.core})
    try:
        peak = peak_flops()
    finally:
        os.sched_setaffinity(0, available)
    parts = operations(paper())
    return {"flop_by_part": parts, "flop": sum(parts.values()), "peak_flop_per_second": peak}


def operations(task: Task) -> dict[str, float]:
    """Operations of one iteration over the whole horizon, by part; an addition or multiplication counts one."""
    x, u = ca.SX.sym("x", task.nx), ca.SX.sym("u", task.nu)
    after, h = step_function(task)(x, u), constraint_function(task)(x)
    a, b, hx = ca.jacobian(after, x), ca.jacobian(after, u), ca.jacobian(h, x)
    nodes = {
        "linearise": _counted([x, u], [after, a, b, h, hx]),
        "backward": _riccati(task.nx, task.nu, a.nnz(), b.nnz()),
        "forward": 2.0 * (task.nu * task.nx + a.nnz() + b.nnz() + hx.nnz()),
        "rollout": _counted([x, u], [after, h]),
    }
    return {name: task.horizon * count for name, count in nodes.items()}


def _riccati(nx: int, nu: int, a: int, b: int) -> float:
    """One step backwards, without active constraints; a and b are numbers of entries that are not zero.

    P A and P B; the symmetric AᵀPA and BᵀPB by half; BᵀPA; Cholesky of Q_uu; both triangular solves for the gains;
    the symmetric P = Q_xx − Q_xu K by half; the same with vectors.
    """
    products = 2.0 * nx * (a + b) + a * (nx + 1) + b * (nu + 1) + 2.0 * b * nx
    cholesky = nu**3 / 3.0 + nu * (2.0 * DIVISION)
    solves = 2.0 * nu**2 * nx
    update = nx * (nx + 1) * nu
    vectors = 2.0 * (nx * nx + a + b + nu**2 + 2.0 * nu * nx)
    return products + cholesky + solves + update + vectors


def _counted(arguments: list[ca.SX], results: list[ca.SX]) -> float:
    """Instructions of an expression after common ones are shared."""
    function = ca.Function("counted", arguments, ca.cse(results))
    counts = Counter(function.instruction_id(i) for i in range(function.n_instructions()))
    weights = {
        **dict.fromkeys((ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_SQ, ca.OP_TWICE), 1.0),
        **dict.fromkeys((ca.OP_DIV, ca.OP_SQRT, ca.OP_INV), DIVISION),
        **dict.fromkeys((ca.OP_SIN, ca.OP_COS, ca.OP_TAN, ca.OP_TANH), TRIGONOMETRY),
    }
    free = {ca.OP_INPUT, ca.OP_OUTPUT, ca.OP_CONST, ca.OP_NEG}
    unknown = counts.keys() - weights.keys() - free
    if unknown:
        raise ValueError(f"operations without a weight: {sorted(unknown)}")
    return float(sum(weights.get(operation, 0.0) * count for operation, count in counts.items()))


def peak_flops() -> float:
    """Multiplications and additions a second that one core reaches with independent fused multiply-adds in registers."""
    _multiply_add(10)
    best = float("inf")
    for _ in range(7):
        started = time.perf_counter()
        _multiply_add(_TURNS)
        best = min(best, time.perf_counter() - started)
    return 2.0 * _WIDTH * _ACCUMULATORS * _TURNS / best


@builtin
def _vectors(typing_context: Any, turns: Any) -> Any:
    """A loop over `turns` of one fused multiply-add on each accumulator, a vector that LLVM keeps in registers."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        vector, integer = ir.VectorType(ir.DoubleType(), _WIDTH), ir.IntType(64)
        name = f"llvm.fma.v{_WIDTH}f64"
        fma = cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector, [vector] * 3), name)
        factor, term = ir.Constant(vector, [0.999999] * _WIDTH), ir.Constant(vector, [1e-9] * _WIDTH)
        before, loop, after = builder.block, builder.append_basic_block(), builder.append_basic_block()
        builder.branch(loop)
        builder.position_at_end(loop)
        turn = builder.phi(integer)
        turn.add_incoming(ir.Constant(integer, 0), before)
        accumulators = [builder.phi(vector) for _ in range(_ACCUMULATORS)]
        for k, accumulator in enumerate(accumulators):
            accumulator.add_incoming(ir.Constant(vector, [k + 1.0] * _WIDTH), before)
            accumulator.add_incoming(builder.call(fma, [accumulator, factor, term]), loop)
        following = builder.add(turn, ir.Constant(integer, 1))
        turn.add_incoming(following, loop)
        builder.cbranch(builder.icmp_signed("<", following, arguments[0]), loop, after)
        builder.position_at_end(after)
        total = accumulators[0]
        for accumulator in accumulators[1:]:
            total = builder.fadd(total, accumulator)
        return builder.extract_element(total, ir.Constant(ir.IntType(32), 0))

    return types.float64(types.int64), generate


def _repeat(turns: int) -> float:
    return float(_vectors(turns))


_multiply_add: Any = numba.njit(_repeat)
