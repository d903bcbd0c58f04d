"""Tables of functions: how compiled code calls what it was not compiled for.

A kernel that takes a table calls its functions by their places in it, at addresses that the table holds when the kernel runs.
So one kernel serves all tables, and is compiled and cached once. Each function of a table takes first what the table holds, a
handle, and a number that the caller has put beside it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import models, register_model, unbox
from numba.core.imputils import lower_builtin
from numba.core.pythonapi import NativeValue
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.np.arrayobj import populate_array

from doorman.numba_types.lanes import builtin
from doorman.numba_types.pointers import BYTES, address_of

_LONG = ir.IntType(64)


class FunctionTableType(types.Type):
    """numba's type of a table, the same for all."""


TABLE = FunctionTableType(name="FunctionTable")


@register_model(FunctionTableType)
class _TableModel(models.StructModel):
    def __init__(self, dmm: Any, fe_type: FunctionTableType) -> None:
        super().__init__(dmm, fe_type, [("memory", types.voidptr), ("number", types.int64)])


class FunctionTable:
    """Addresses of C functions, and what they work on.

    Args:
        held: Address of what all functions take first.
        functions: Address of each function; 0 for one without a caller.
    """

    __slots__ = ("address", "_memory")
    _numba_type_ = TABLE

    def __init__(self, held: int, functions: list[int]) -> None:
        self._memory = np.array([held, *functions], dtype=np.int64)
        self.address = int(self._memory.ctypes.data)


@unbox(FunctionTableType)
def _unbox_table(typ: FunctionTableType, obj: Any, c: Any) -> NativeValue:
    table = cgutils.create_struct_proxy(typ)(c.context, c.builder)
    table.memory = address_of(obj, c)
    table.number = ir.Constant(_LONG, 0)
    return NativeValue(table._getvalue(), is_error=c.pyapi.c_api_error())


@builtin
def with_number(typingctx: Any, table: Any, number: Any) -> Any:
    """A table with another number beside it."""
    if table is not TABLE:
        return None

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        changed = cgutils.create_struct_proxy(table)(context, builder, value=args[0])
        changed.number = context.cast(builder, args[1], sig.args[1], types.int64)
        return changed._getvalue()

    return TABLE(table, number), build


def taught(name: str, place: int, returns: Any) -> Any:
    """What compiled code calls for a table's function at a place, with the table, a number and the other arguments."""

    def function(*_: Any) -> Any:
        raise NotImplementedError(f"{name} exists in compiled code only")

    function.__name__ = name

    class Template(AbstractTemplate):
        key = function

        def generic(self, args: Any, kws: Any) -> Any:
            return signature(returns, *args) if args and args[0] is TABLE else None

    @lower_builtin(function, FunctionTableType, types.VarArg(types.Any))
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        table = cgutils.create_struct_proxy(TABLE)(context, builder, value=args[0])
        table.number = context.cast(builder, args[1], sig.args[1], types.int64)
        rest = signature(sig.return_type, sig.args[0], *sig.args[2:])
        return call(context, builder, place, rest, [table._getvalue(), *args[2:]])

    infer_global(function, types.Function(Template))
    return function


def call(context: Any, builder: Any, place: int, sig: Any, args: Any) -> Any:
    """Write the call of a table's function, which takes its handle, its number and the arguments after the table."""
    table = cgutils.create_struct_proxy(TABLE)(context, builder, value=args[0])
    memory = builder.bitcast(table.memory, _LONG.as_pointer())
    held, address = (builder.load(builder.gep(memory, [ir.Constant(_LONG, i)])) for i in (0, 1 + place))
    passed = [builder.inttoptr(held, BYTES), table.number]
    for kind, value in zip(sig.args[1:], args[1:], strict=True):
        if isinstance(kind, types.Array):
            array = context.make_array(kind)(context, builder, value)
            passed += [array.data, *cgutils.unpack_tuple(builder, array.shape)]
        else:
            passed.append(value)
    form = ir.FunctionType(context.get_value_type(sig.return_type), [each.type for each in passed])
    return builder.call(builder.inttoptr(address, form.as_pointer()), passed)


def wrap(context: Any, library: Any, code: Any) -> None:
    """Write the function that `call` calls, around a kernel's code: of a C-contiguous array it takes data and lengths."""
    described, module = code.fndesc, context.create_module("function_of_table")
    inner_kind = context.call_conv.get_function_type(described.restype, described.argtypes)
    inner = ir.Function(module, inner_kind, described.llvm_func_name)
    taken: list[Any] = []
    for kind in described.argtypes:
        if isinstance(kind, types.Array):
            taken += [context.get_value_type(kind.dtype).as_pointer(), *[_LONG] * kind.ndim]
        else:
            taken.append(context.get_value_type(kind))
    outer_kind = ir.FunctionType(context.get_value_type(described.restype), taken)
    outer = ir.Function(module, outer_kind, described.llvm_cfunc_wrapper_name)
    builder = ir.IRBuilder(outer.append_basic_block("entry"))
    given, passed = iter(outer.args), []
    for kind in described.argtypes:
        value = next(given)
        if isinstance(kind, types.Array):
            lengths = [next(given) for _ in range(kind.ndim)]
            array = context.make_array(kind)(context, builder)
            size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
            steps = [ir.Constant(_LONG, size)]
            for length in reversed(lengths[1:]):
                steps.insert(0, builder.mul(steps[0], length))
            populate_array(array, value, lengths, steps, ir.Constant(_LONG, size), meminfo=None)
            value = array._getvalue()
        passed.append(value)
    _, result = context.call_conv.call_function(builder, inner, described.restype, described.argtypes, passed)
    builder.ret(result)
    library.add_ir_module(module)
