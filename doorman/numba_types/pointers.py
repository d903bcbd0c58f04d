"""Calls of a C function of two pointers, such as an engine's step, from compiled code.

All three addresses are numbers that a kernel is given, so that it is cached like all others.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types

from doorman.numba_types.lanes import builtin


@builtin
def call_with_two(typingctx: Any, address: Any, first: Any, second: Any) -> Any:
    """Call `void f(void* first, void* second)`."""
    pointer = ir.IntType(8).as_pointer()
    kind = ir.FunctionType(ir.VoidType(), [pointer, pointer])

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        function, *given = (
            context.cast(builder, value, each, types.int64) for value, each in zip(args, sig.args, strict=True)
        )
        pointers = [builder.inttoptr(value, pointer) for value in given]
        builder.call(builder.inttoptr(function, kind.as_pointer()), pointers)
        return context.get_dummy_value()

    return types.void(address, first, second), build
