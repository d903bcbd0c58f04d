"""Calls of a C function at an address, from compiled code: how kernels reach Python functions.

The address is a number in a model's memory, so that kernels which call are cached like all others. `ctypes.CFUNCTYPE` makes
such a function of a Python one and takes the GIL for the time of each call.
"""

from __future__ import annotations

import ctypes
from typing import Any

from llvmlite import ir
from numba.core import types

from doorman.numba_types.lanes import builtin

C_FUNCTION = ctypes.CFUNCTYPE(None, ctypes.c_int64, *[ctypes.c_void_p] * 4)
"""void f(int64 task, double* x, double* u, double* out, double* slopes)."""


@builtin
def call(typingctx: Any, address: Any, task: Any, x: Any, u: Any, out: Any, slopes: Any) -> Any:
    """Call a `C_FUNCTION`."""
    arrays = (x, u, out, slopes)
    if not all(isinstance(array, types.Array) and array.layout == "C" for array in arrays):
        return None
    pointer = ir.IntType(8).as_pointer()
    kind = ir.FunctionType(ir.VoidType(), [ir.IntType(64), *[pointer] * len(arrays)])

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        function = builder.inttoptr(context.cast(builder, args[0], sig.args[0], types.int64), kind.as_pointer())
        pointers = [
            builder.bitcast(context.make_array(each)(context, builder, array).data, pointer)
            for each, array in zip(sig.args[2:], args[2:], strict=True)
        ]
        builder.call(function, [context.cast(builder, args[1], sig.args[1], types.int64), *pointers])
        return context.get_dummy_value()

    return types.void(address, task, *arrays), build
