"""Active set of a trajectory's rows and bounds, and the multipliers that follow, as vector code for the sizes at hand."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types
from numpy.typing import NDArray

from doorman.compilation import kernel
from doorman.numba_types.emitter import DOUBLE, Emitter
from doorman.numba_types.lanes import builtin
from doorman.ocp.solvers.parts import Sides, Trajectory
from doorman.ocp.solvers.workspace import Workspace

Array = NDArray[np.float64]

_RESULT: Any = types.Tuple((types.int64, types.boolean))  # type: ignore[no-untyped-call]


class _Marker(Emitter):
    """Classification of all rows of one node at once."""

    def row(self, kind: Any, array: Any, index: Any, count: int) -> Any:
        """Pointer to a row of a C-contiguous array."""
        return self.offset(self.data(kind, array), index, count)

    def positive(self, force: Any) -> Any:
        """max(0, force); NaN stays."""
        least = ir.Constant(force.type, None)
        return self.builder.select(self.builder.fcmp_ordered("<", force, least), least, force)

    def mark(self, context: Any, pointer: Any, above: Any, below: Any) -> Any:
        """Write 1 where `above`, −1 where `below`: how many that are, and whether any of them changed."""
        count, builder = above.type.count, self.builder
        sides, bits, long = ir.VectorType(ir.IntType(8), count), ir.IntType(count), ir.IntType(64)
        place = builder.bitcast(pointer, sides.as_pointer())
        before, now = builder.load(place, align=1), builder.sub(builder.zext(above, sides), builder.zext(below, sides))
        builder.store(now, place, align=1)
        flipped = builder.bitcast(builder.icmp_unsigned("!=", before, now), bits)
        marked = builder.ctpop(builder.bitcast(builder.or_(above, below), bits))
        if count != long.width:
            marked = builder.zext(marked, long) if count < long.width else builder.trunc(marked, long)
        changed = builder.zext(builder.icmp_unsigned("!=", flipped, ir.Constant(bits, 0)), ir.IntType(1))
        return context.make_tuple(builder, _RESULT, (marked, changed))


@kernel
def mark_rows(
    k: int, rows: Array, multipliers: Array, scale: float, floors: Array, active: Sides, proposal: Array
) -> tuple[int, bool]:
    """Rows r ≤ 0 of one node: active where λ + r/μ > 0, with max(0, λ + r/μ) as their next multipliers."""
    count, flipped = 0, 0
    for i in range(floors.shape[0]):
        force, floor = multipliers[k, i] + scale * rows[k, i], floors[i]
        side = int(force > floor)
        proposal[k, i] = floor if force < floor else force
        flipped |= active[k, i] ^ side
        count += side
        active[k, i] = side
    return count, flipped != 0


@builtin
def mark_bounds(
    typingctx: Any, node: Any, count: Any, values: Any, first: Any, lower: Any, upper: Any, multipliers: Any, scale: Any,
    active: Any, proposal: Any,
) -> Any:  # fmt: skip
    """Bounds lower ≤ v ≤ upper of one node: active 1 at the upper end and −1, with a negative multiplier, at the lower one."""
    n = len(count)
    arguments = (node, count, values, first, lower, upper, multipliers, scale, active, proposal)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        emit = _Marker(context, builder)
        k = context.cast(builder, args[0], sig.args[0], types.intp)
        place = builder.add(k, context.cast(builder, args[3], sig.args[3], types.intp))
        value = emit.load(emit.row(sig.args[2], args[2], place, n), 0, n)
        multiplier, side, new = (emit.row(sig.args[i], args[i], k, n) for i in (6, 8, 9))
        factor = emit.spread(context.cast(builder, args[7], sig.args[7], types.float64), n)
        held, zero = emit.load(multiplier, 0, n), ir.Constant(ir.VectorType(DOUBLE, n), None)
        below, above = (
            emit.add(
                held, emit.multiply(factor, emit.subtract(value, emit.load(emit.data(sig.args[i], args[i]), 0, n)))
            )
            for i in (4, 5)
        )
        emit.store(new, 0, emit.subtract(emit.positive(above), emit.positive(builder.fneg(below))))
        over, under = builder.fcmp_ordered(">", above, zero), builder.fcmp_ordered("<", below, zero)
        return emit.mark(context, side, over, under)

    return _RESULT(*arguments), build


@kernel
def classify(work: Workspace, at: Trajectory, penalty: float) -> int:
    """Active set {λ + r/μ > 0} and proposed multipliers max(0, λ + r/μ) at a trajectory's rows."""
    active, multipliers, proposal, limits, sizes = work.active, work.multipliers, work.proposal, work.limits, work.sizes
    floors, last, n = work.floors, -1, at.inputs.shape[0]
    for k in range(n):
        stiff = penalty * work.stiffness[k]
        h, g, x, u = 0, 0, 0, 0
        h_changed, g_changed, x_changed, u_changed = False, False, False, False
        if sizes.rows > 0:
            h, h_changed = mark_rows(k, at.rows, multipliers.rows, stiff, floors.rows, active.rows, proposal.rows)
        if sizes.state_bounds > 0:
            x, x_changed = mark_bounds(
                k, sizes.states, at.states, 1, limits.state_lower, limits.state_upper, multipliers.states, stiff,
                active.states, proposal.states,
            )  # fmt: skip
        if sizes.input_rows > 0:
            g, g_changed = mark_rows(
                k,
                at.input_rows,
                multipliers.input_rows,
                penalty,
                floors.input_rows,
                active.input_rows,
                proposal.input_rows,
            )
        if sizes.input_bounds > 0:
            u, u_changed = mark_bounds(
                k, sizes.inputs, at.inputs, 0, limits.input_lower, limits.input_upper, multipliers.inputs, penalty,
                active.inputs, proposal.inputs,
            )  # fmt: skip
        active.state_count[k], active.input_count[k] = h + x, g + u
        if h_changed or x_changed or g_changed or u_changed:
            last = k
    one = (1, sizes.end_rows)
    end, end_changed = mark_rows(
        0, at.end_rows.reshape(one), multipliers.end_rows.reshape(one), penalty, floors.end_rows,
        active.end_rows.reshape(one), proposal.end_rows.reshape(one),
    )  # fmt: skip
    active.state_count[n - 1] += end  # they count as rows of the last state
    return n - 1 if end_changed else last
