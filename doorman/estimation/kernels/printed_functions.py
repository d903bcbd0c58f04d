"""How the kernels of a bank call what was printed: at an address, so that they are compiled once and not for each filter."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import cgutils, types

from doorman.numba_types.function_tables import wrap
from doorman.numba_types.lanes import builtin

_VECTOR = types.Array(types.float64, 1, "C")
_KINDS = (_VECTOR, _VECTOR, _VECTOR, types.float64, _VECTOR)
"""x, u, p, h and out."""


def address_of(printed_kernel: Any) -> int:
    """Address of a printed kernel of (x, u, p, h, out)."""
    return int(printed_kernel.address(_KINDS, wrap))


@builtin
def call_printed(typingctx: Any, address: Any, x: Any, u: Any, p: Any, h: Any, out: Any) -> Any:
    """Call a printed kernel at its address."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        passed: list[Any] = []
        for kind, value in zip(sig.args[1:], args[1:], strict=True):
            if isinstance(kind, types.Array):
                array = context.make_array(kind)(context, builder, value)
                passed += [array.data, *cgutils.unpack_tuple(builder, array.shape)]  # type: ignore[no-untyped-call]
            else:
                passed.append(value)
        form = ir.FunctionType(context.get_value_type(sig.return_type), [each.type for each in passed])
        return builder.call(builder.inttoptr(args[0], form.as_pointer()), passed)

    return types.void(types.int64, *_KINDS), build
