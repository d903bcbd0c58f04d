r"""One node of a Riccati sweep, as straight-line vector code for the sizes at hand.

The dynamics' rows are [A | e | B] with the defect e, the value function's [V_xx | V_x]: one product carries Hessian and
gradient together. The inputs' rows [Q_ux | Q_u | Q_uu] are eliminated by :math:`Q_{uu} = U^T D U` with U unit upper triangular
and D diagonal, which has no roots. With R the rows in the course of the elimination and L = D⁻¹R:

.. math:: V_{xx} = Q_{xx} - R_x^T L_x,\quad V_x = Q_x - R_x^T L_e,\quad [K | k] = -U^{-1}[L_x | L_e]

The last m states may be integrators of the last m inputs, :math:`x^+ = x + \Delta t\,u` without a defect (an arm's joints): their
rows of A and B are not multiplied but copied.

numba would loop over rows of which the compiler cannot know how many there are left to eliminate. Here every loop over the
sizes is unrolled while the code is generated, so that rows stay in registers.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types

from doorman.numba_types.emitter import DOUBLE, Emitter
from doorman.numba_types.handles import HandleType
from doorman.numba_types.lanes import builtin


@builtin
def eliminate_inputs(
    typingctx: Any, sizes: Any, node: Any, time_step: Any, jacobians: Any, value: Any, base_x: Any, base_u: Any,
    gains: Any, factors: Any, values: Any, rows: Any, scaled: Any,
) -> Any:  # fmt: skip
    """Value function of node k from that of node k + 1, and the policy between them.

    Args:
        typingctx: numba's.
        sizes: `Sizes`.
        node: k.
        time_step: Δt of the integrators.
        jacobians: [A | e | B] of all nodes, (N, nx, wide).
        value: [V_xx | V_x], (nx, narrow); of node k + 1 before, of node k after.
        base_x: [Q_xx | Q_x] of the stage cost, (nx, narrow).
        base_u: [Q_ux | Q_u | Q_uu] of the stage cost, (nu, wide).
        gains: [K | k] of all nodes, (N, nu, narrow).
        factors: U of all nodes with D on its diagonal, (N, nu, padded nu).
        values: [V_xx | V_x] of all nodes, (N, nx, narrow).
        rows: R of this node, (nu, wide).
        scaled: L of this node, (nu, wide).

    Returns:
        Whether Q_uu is positive definite.
    """
    held = sizes.content if isinstance(sizes, HandleType) else sizes
    nx, nu, m, narrow, wide = (
        len(held[held.fields.index(name)]) for name in ("states", "inputs", "integrators", "narrow", "wide")
    )
    padded = factors_width(nu)
    arrays = (jacobians, value, base_x, base_u, gains, factors, values, rows, scaled)
    s, v, g, first_input = nx - m, nu - m, nx, nx + 1

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        emit = Emitter(context, builder)
        k = context.cast(builder, args[1], sig.args[1], types.intp)
        pointers = [emit.data(kind, array) for kind, array in zip(sig.args[3:], args[3:], strict=True)]
        jac, val, cost_x, cost_u, policy, upper, kept, left, right = pointers
        jac = emit.offset(jac, k, nx * wide)
        policy = emit.offset(policy, k, nu * narrow)
        upper = emit.offset(upper, k, nu * padded)
        kept = emit.offset(kept, k, nx * narrow)
        step = emit.spread(context.cast(builder, args[2], sig.args[2], types.float64), wide)
        zero = ir.Constant(ir.VectorType(DOUBLE, narrow), None)
        ones = ir.Constant(ir.VectorType(DOUBLE, wide), [1.0] * wide)
        integrated = {first_input + v + i: s + i for i in range(m)}  # column of an input: column of its integral
        scale = emit.pick(ones, [wide + c if c in integrated else c for c in range(wide)], step)
        source = [integrated.get(c, c if s <= c <= g else narrow) for c in range(wide)]  # lane `narrow` is a zero

        dynamics = [emit.load(jac, i * wide, wide) for i in range(s)]
        product = []
        for i in range(nx):
            total = emit.multiply(emit.pick(emit.load(val, i * narrow, narrow), source, zero), scale)
            for j in range(s):
                total = emit.add(total, emit.multiply(emit.number(val, i * narrow + j, wide), dynamics[j]))
            product.append(total)
        short = [emit.pick(each, list(range(narrow))) for each in product]

        state_rows = []
        for i in range(nx):
            total = emit.load(cost_x, i * narrow, narrow)
            for j in range(s) if i < s else ():
                total = emit.add(total, emit.multiply(emit.number(jac, j * wide + i, narrow), short[j]))
            state_rows.append(total if i < s else emit.add(total, short[i]))
        input_rows = []
        for b in range(nu):
            total = emit.load(cost_u, b * wide, wide)
            for j in range(s) if b < v else ():
                total = emit.add(total, emit.multiply(emit.number(jac, j * wide + first_input + b, wide), product[j]))
            input_rows.append(total if b < v else emit.add(total, emit.multiply(step, product[s + b - v])))

        positive = ir.Constant(ir.IntType(1), 1)
        unit = []
        for a in range(nu):
            row = input_rows[a]
            emit.store(left, a * wide, row)
            pivot = builder.extract_element(row, ir.Constant(ir.IntType(32), first_input + a))
            positive = builder.and_(positive, builder.fcmp_ordered(">", pivot, ir.Constant(DOUBLE, 1e-14)))
            inverse = builder.fdiv(ir.Constant(DOUBLE, 1.0), pivot)
            unit.append(emit.multiply(row, emit.spread(inverse, wide)))
            emit.store(right, a * wide, unit[a])
            for c in range(a + 1, nu):
                share = emit.pick(unit[a], [first_input + c] * wide)
                input_rows[c] = emit.subtract(input_rows[c], emit.multiply(share, row))
            window = [first_input + min(c, nu - 1) for c in range(padded)]
            emit.store(upper, a * padded, emit.pick(unit[a], window))
            emit.store(upper, a * padded + a, pivot)
        for i in range(nx):
            total = state_rows[i]
            for a in range(nu):
                share = emit.pick(input_rows[a], [i] * narrow)
                total = emit.subtract(total, emit.multiply(share, emit.pick(unit[a], list(range(narrow)))))
            emit.store(val, i * narrow, total)
            emit.store(kept, i * narrow, total)
        feedback: list[Any] = [None] * nu
        for b in reversed(range(nu)):
            total = builder.fneg(emit.pick(unit[b], list(range(narrow))))
            for a in range(b + 1, nu):
                share = emit.pick(unit[b], [first_input + a] * narrow)
                total = emit.subtract(total, emit.multiply(share, feedback[a]))
            feedback[b] = total
            emit.store(policy, b * narrow, total)
        return positive

    return types.boolean(sizes, node, time_step, *arrays), build


def factors_width(nu: int) -> int:
    """Length of a row of the factors: nu, padded.

    Args:
        nu: Number of inputs.
    """
    return -(-nu // 8) * 8
