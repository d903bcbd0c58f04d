"""Pointers in compiled code: to what Python's objects hold, and to C functions of two pointers, such as an engine's step."""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.extending import models, register_model, unbox
from numba.core.pythonapi import NativeValue

from doorman.numba_types.lanes import builtin

BYTES = ir.IntType(8).as_pointer()


class _PointerModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Any) -> None:
        super().__init__(dmm, fe_type, BYTES)


def passed_as_pointer(kind: Any) -> Any:
    """Decorator of a numba type: kernels take the `address` of its objects."""

    def unboxed(typ: Any, obj: Any, c: Any) -> NativeValue:
        return NativeValue(address_of(obj, c), is_error=c.pyapi.c_api_error())

    unbox(kind)(unboxed)
    register_model(kind)(_PointerModel)
    return kind


def address_of(obj: Any, c: Any) -> Any:
    """Pointer that the attribute `address` of one of Python's objects holds."""
    attribute = c.pyapi.object_getattr_string(obj, "address")
    address = c.pyapi.long_as_longlong(attribute)
    c.pyapi.decref(attribute)
    return c.builder.inttoptr(address, BYTES)


@builtin
def call_with_two(typingctx: Any, address: Any, first: Any, second: Any) -> Any:
    """Call `void f(void* first, void* second)`; the addresses are numbers that a kernel is given, so that it is cached."""
    kind = ir.FunctionType(ir.VoidType(), [BYTES, BYTES])

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        function, *given = (
            context.cast(builder, value, each, types.int64) for value, each in zip(args, sig.args, strict=True)
        )
        pointers = [builder.inttoptr(value, BYTES) for value in given]
        builder.call(builder.inttoptr(function, kind.as_pointer()), pointers)
        return context.get_dummy_value()

    return types.void(address, first, second), build
