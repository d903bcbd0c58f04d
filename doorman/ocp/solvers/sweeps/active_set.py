"""Active set of a trajectory's rows and bounds, and the multipliers that follow, as vector code for the sizes at hand."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types

from doorman.compilation import kernel
from doorman.numba_types.emitter import DOUBLE, Emitter
from doorman.numba_types.lanes import builtin
from doorman.ocp.solvers.parts import Trajectory
from doorman.ocp.solvers.workspace import Workspace

_RESULT: Any = types.Tuple((types.int64, types.boolean))  # type: ignore[no-untyped-call]


class _Marker(Emitter):
    """Classification of all rows of one node at once."""

    def row(self, kind: Any, array: Any, index: Any, count: int) -> Any:
        """Pointer to a row of a C-contiguous array."""
        return self.offset(self.data(kind, array), index, count)

    def positive(self, force: Any, floor: Any = None) -> Any:
        """max(0, force), or max(floor, force); NaN stays."""
        least = ir.Constant(force.type, None) if floor is None else floor
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


def _nothing(context: Any, builder: Any) -> Any:
    return context.make_tuple(builder, _RESULT, (ir.Constant(ir.IntType(64), 0), ir.Constant(ir.IntType(1), 0)))


@builtin
def mark_rows(
    typingctx: Any, node: Any, count: Any, rows: Any, multipliers: Any, scale: Any, active: Any, proposal: Any,
    equalities: Any, floors: Any,
) -> Any:  # fmt: skip
    """Rows r ≤ 0 of one node: active where λ + r/μ > 0, with max(0, λ + r/μ) as their next multipliers.

    Args:
        typingctx: numba's.
        node: k.
        count: Tuple as long as a node has rows.
        rows: r of all nodes, (N, count); or the end rows, (count,), with node 0.
        multipliers: λ, of the same shape.
        scale: 1/μ.
        active: 1 or 0, of the same shape, int8.
        proposal: Of the same shape.
        equalities: Empty tuple where no row is an equality.
        floors: Least multiplier of every row, (count,): 0, or −inf for r = 0, which is always active.

    Returns:
        How many are active, and whether another set is than before.
    """
    n = len(count)
    arguments = (node, count, rows, multipliers, scale, active, proposal, equalities, floors)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if n == 0:
            return _nothing(context, builder)
        emit = _Marker(context, builder)
        k = context.cast(builder, args[0], sig.args[0], types.intp)
        r, multiplier, side, new = (emit.row(sig.args[i], args[i], k, n) for i in (2, 3, 5, 6))
        factor = emit.spread(context.cast(builder, args[4], sig.args[4], types.float64), n)
        force = emit.add(emit.load(multiplier, 0, n), emit.multiply(factor, emit.load(r, 0, n)))
        floor = emit.load(emit.data(sig.args[8], args[8]), 0, n) if len(equalities) else ir.Constant(force.type, None)
        emit.store(new, 0, emit.positive(force, floor))
        above = builder.fcmp_ordered(">", force, floor)
        return emit.mark(context, side, above, ir.Constant(above.type, None))

    return _RESULT(*arguments), build


@builtin
def mark_bounds(
    typingctx: Any, node: Any, count: Any, values: Any, first: Any, lower: Any, upper: Any, multipliers: Any, scale: Any,
    active: Any, proposal: Any,
) -> Any:  # fmt: skip
    """The same of lower ≤ v ≤ upper: 1 at the upper end and −1, with a negative multiplier, at the lower one.

    Args:
        typingctx: numba's.
        node: k.
        count: Tuple as long as a node has values, or empty where none is bounded.
        values: v of all nodes.
        first: Row of `values` that belongs to node 0.
        lower: Shape (count,).
        upper: Shape (count,).
        multipliers: λ of all nodes, (N, count).
        scale: 1/μ.
        active: Sides, of the same shape, int8.
        proposal: Of the same shape.

    Returns:
        How many are active, and whether another set is than before.
    """
    n = len(count)
    arguments = (node, count, values, first, lower, upper, multipliers, scale, active, proposal)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        if n == 0:
            return _nothing(context, builder)
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
    """Active set {λ + r/μ > 0} and proposed multipliers max(0, λ + r/μ) at a trajectory's rows.

    Returns:
        The last node whose set is another now; −1 if none is.
    """
    active, multipliers, proposal, limits, sizes = work.active, work.multipliers, work.proposal, work.limits, work.sizes
    equal, floors = sizes.equalities, work.floors
    last, n = -1, at.inputs.shape[0]
    for k in range(n):
        stiff = penalty * work.stiffness[k]
        h, h_changed = mark_rows(
            k, sizes.rows, at.rows, multipliers.rows, stiff, active.rows, proposal.rows, equal, floors.rows
        )
        x, x_changed = mark_bounds(
            k, sizes.state_bounds, at.states, 1, limits.state_lower, limits.state_upper, multipliers.states, stiff,
            active.states, proposal.states,
        )  # fmt: skip
        g, g_changed = mark_rows(
            k, sizes.input_rows, at.input_rows, multipliers.input_rows, penalty, active.input_rows, proposal.input_rows,
            equal, floors.input_rows,
        )  # fmt: skip
        u, u_changed = mark_bounds(
            k, sizes.input_bounds, at.inputs, 0, limits.input_lower, limits.input_upper, multipliers.inputs, penalty,
            active.inputs, proposal.inputs,
        )  # fmt: skip
        active.state_count[k], active.input_count[k] = h + x, g + u
        if h_changed or x_changed or g_changed or u_changed:
            last = k
    end, end_changed = mark_rows(
        0, sizes.end_rows, at.end_rows, multipliers.end_rows, penalty, active.end_rows, proposal.end_rows, equal,
        floors.end_rows,
    )  # fmt: skip
    active.state_count[n - 1] += end  # they count as rows of the last state
    return n - 1 if end_changed else last
