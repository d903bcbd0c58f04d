"""Bounds of one node, as vector code for the sizes at hand: which of them are active, and the multipliers that follow."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types

from doorman.numba_types.emitter import DOUBLE, Emitter
from doorman.numba_types.lanes import builtin

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


@builtin
def mark_bounds(
    typingctx: Any, node: Any, count: Any, values: Any, lower: Any, upper: Any, multipliers: Any, scale: Any,
    active: Any, proposal: Any,
) -> Any:  # fmt: skip
    """Bounds lower ≤ v ≤ upper of one node: active 1 at the upper end and −1, with a negative multiplier, at the lower one."""
    n = len(count)
    arguments = (node, count, values, lower, upper, multipliers, scale, active, proposal)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        emit = _Marker(context, builder)
        k = context.cast(builder, args[0], sig.args[0], types.intp)
        value = emit.load(emit.data(sig.args[2], args[2]), 0, n)
        multiplier, side, new = (emit.row(sig.args[i], args[i], k, n) for i in (5, 7, 8))
        factor = emit.spread(context.cast(builder, args[6], sig.args[6], types.float64), n)
        held, zero = emit.load(multiplier, 0, n), ir.Constant(ir.VectorType(DOUBLE, n), None)
        below, above = (
            emit.add(
                held, emit.multiply(factor, emit.subtract(value, emit.load(emit.data(sig.args[i], args[i]), 0, n)))
            )
            for i in (3, 4)
        )
        emit.store(new, 0, emit.subtract(emit.positive(above), emit.positive(builder.fneg(below))))
        over, under = builder.fcmp_ordered(">", above, zero), builder.fcmp_ordered("<", below, zero)
        return emit.mark(context, side, over, under)

    return _RESULT(*arguments), build
