"""Products of a matrix's rows with a vector, unrolled for the sizes at hand."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types

from doorman.numba_types.lanes import builtin, row_pointer


@builtin
def multiply_rows(
    typingctx: Any, matrix: Any, block: Any, count: Any, width: Any, vector: Any, out: Any, start: Any
) -> Any:
    """Product of a matrix's first rows with a vector, `out[start + i] = Σ_j matrix[block, i, j] vector[j]`."""
    n_columns = len(width)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.VectorType(ir.DoubleType(), n_columns)
        reduce = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(ir.DoubleType(), [ir.DoubleType(), kind]),
            f"llvm.vector.reduce.fadd.v{n_columns}f64",
        )  # fmt: skip
        first = context.get_constant(types.intp, 0)
        index = [context.cast(builder, args[1], sig.args[1], types.intp)]
        begin = context.cast(builder, args[6], sig.args[6], types.intp)
        x = builder.load(row_pointer(context, builder, sig.args[4], args[4], [first], n_columns), align=8)
        target = context.make_array(sig.args[5])(context, builder, args[5]).data

        def multiply(i: Any) -> None:
            place = [*index, i, first]
            row = builder.load(row_pointer(context, builder, sig.args[0], args[0], place, n_columns), align=8)
            product = builder.fmul(row, x)
            zero = ir.Constant(ir.DoubleType(), -0.0)
            total = builder.call(reduce, [zero, product], fastmath=("reassoc", "nsz", "contract"))
            builder.store(total, builder.gep(target, [builder.add(begin, i)]))

        if isinstance(count, types.BaseTuple):
            for i in range(len(count)):
                multiply(context.get_constant(types.intp, i))
        else:
            with cgutils.for_range(builder, context.cast(builder, args[2], sig.args[2], types.intp)) as loop:
                multiply(loop.index)
        return context.get_dummy_value()

    return types.void(matrix, block, count, width, vector, out, start), build
