"""A clock for compiled code."""

from __future__ import annotations

import time
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types

from doorman.numba_types.lanes import builtin


@builtin
def clock(typingctx: Any) -> Any:
    """Time of the monotonic clock, the one of `time.monotonic` [s]."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        long = ir.IntType(64)
        spec = cgutils.alloca_once(builder, ir.ArrayType(long, 2))
        kind = ir.FunctionType(ir.IntType(32), [ir.IntType(32), spec.type])
        read = cgutils.get_or_insert_function(builder.module, kind, "clock_gettime")
        builder.call(read, [ir.Constant(ir.IntType(32), time.CLOCK_MONOTONIC), spec])
        seconds, nanoseconds = (builder.extract_value(builder.load(spec), i) for i in range(2))
        whole = builder.sitofp(seconds, ir.DoubleType())
        part = builder.fmul(builder.sitofp(nanoseconds, ir.DoubleType()), ir.Constant(ir.DoubleType(), 1e-9))
        return builder.fadd(whole, part)

    return types.float64(), build
