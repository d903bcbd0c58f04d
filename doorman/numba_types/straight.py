"""Formulas as kernels without numba's passes: straight lines of Python, run once, whose operations write instructions.

numba infers types and rewrites a function a dozen times, which takes most of the time that a formula of thousands of lines needs
to compile. Here the lines run with values that stand for instructions' results, and each operation appends its own. What is
compiled is what numba would make of a kernel: it is linked, called and cached alike.
"""

from __future__ import annotations

from collections.abc import Callable
from types import FunctionType
from typing import Any, TypeVar

from llvmlite import ir
from numba.core import cgutils, event, types
from numba.core.bytecode import FunctionIdentity
from numba.core.compiler import compile_result
from numba.core.environment import Environment
from numba.core.funcdesc import PythonFunctionDescriptor
from numba.core.typing.templates import signature

from doorman.compilation import kept
from doorman.compilation.dispatcher import Kernel
from doorman.numba_types.elementary import WORDS
from doorman.numba_types.emitter import DOUBLE, FLAGS, INDEX, Emitter
from doorman.numba_types.handles import HandleType, field_of

Function = TypeVar("Function", bound=Callable[..., Any])


def straight(function: Function) -> Function:
    """Compile straight lines: assignments, arithmetic, numbers of arrays and models, and functions of numbers or lanes."""
    compiled: Function = kept(Straight(function), function)
    return compiled


class Straight(Kernel):
    """A kernel whose lines write their instructions themselves."""

    def _compiled(self, args: tuple[Any, ...]) -> Any:
        self._cache_misses[args] += 1
        details = {"dispatcher": self, "args": args, "return_type": None}
        with self._compiling_counter, event.trigger_event("numba:compile", data=details):
            return _written(self, args)


def _written(kernel: Any, args: tuple[Any, ...]) -> Any:
    """What callers link."""
    function, context = kernel.py_func, kernel.targetctx
    context.refresh()
    returns = types.float64 if function.__annotations__.get("return") in (float, "float") else types.none
    number = next(FunctionIdentity._unique_ids)
    names = function.__code__.co_varnames[: len(args)]
    described = PythonFunctionDescriptor(
        True, function.__module__, function.__qualname__, f"{function.__qualname__}${number}", "", {}, returns, {},
        names, (), mangler=context.mangler, argtypes=args, uid=number,
    )  # fmt: skip
    library = context.codegen().create_library(function.__qualname__)
    library.enable_object_caching()
    module = context.create_module(function.__qualname__)
    with context.push_code_library(library):
        made = context.declare_function(module, described)
        builder = ir.IRBuilder(made.append_basic_block("entry"))
        values = context.call_conv.decode_arguments(builder, args, made)
        lines = _Lines(context, builder)
        result = lines.run(function, [lines.known(kind, value) for kind, value in zip(args, values, strict=True)])
        result = context.get_dummy_value() if returns is types.none else lines.value(result)
        context.call_conv.return_value(builder, context.get_return_value(builder, returns, result))
        library.add_ir_module(module)
        library.finalize()
    environment = Environment.from_fndesc(described)
    return compile_result(
        typing_context=kernel.typingctx, target_context=context, entry_point=None, typing_error=None, type_annotation="",
        library=library, call_helper=None, signature=signature(returns, *args), objectmode=False, lifted=(),
        fndesc=described, environment=environment, metadata={}, reload_init=[],
    )  # fmt: skip


class _Lines(Emitter):
    """Instructions of one function."""

    def run(self, function: Any, arguments: list[Any]) -> Any:
        """Write a function's instructions: what it returns."""
        words = {name: self._word(generate) for name, generate in WORDS.items()}
        own = {"get": self._get, "put": _put, "zero": self._zero}
        return FunctionType(function.__code__, {**function.__globals__, **words, **own})(*arguments)

    def known(self, kind: Any, value: Any) -> Any:
        """An argument, or a part of one, as the lines take it."""
        if isinstance(kind, types.Array):
            return _Numbers(self, kind, value)
        if isinstance(kind, HandleType | types.BaseNamedTuple):
            return _Model(self, kind, value)
        return _Value(self, self.context.cast(self.builder, value, kind, types.float64))

    def value(self, given: Any, like: Any = DOUBLE) -> Any:
        """LLVM's value, in all lanes where the other operand has lanes."""
        if not isinstance(given, _Value):
            number = float(given)
            return ir.Constant(like, [number] * like.count if isinstance(like, ir.VectorType) else number)
        wide = isinstance(like, ir.VectorType) and not isinstance(given.value.type, ir.VectorType)
        return self.spread(given.value, like.count) if wide else given.value

    def alike(self, *given: Any) -> list[Any]:
        """LLVM's values of one type: lanes if any has lanes."""
        kinds = [each.value.type for each in given if isinstance(each, _Value)]
        kind = next((each for each in kinds if isinstance(each, ir.VectorType)), DOUBLE)
        return [self.value(each, kind) for each in given]

    def operate(self, name: str, left: Any, right: Any) -> _Value:
        """Result of an operation on two numbers."""
        return _Value(self, getattr(self.builder, name)(*self.alike(left, right), flags=FLAGS))

    def _word(self, generate: Callable[..., Any]) -> Callable[..., Any]:
        def call(*given: Any) -> Any:
            result = generate(self.builder, *self.alike(*given))
            return tuple(_Value(self, each) for each in result) if isinstance(result, tuple) else _Value(self, result)

        return call

    def _get(self, array: _Numbers, i: int, lanes: tuple[int, ...]) -> _Value:
        return _Value(self, self.load(array.data, i * len(lanes), len(lanes)))

    def _zero(self, lanes: tuple[int, ...]) -> _Value:
        return _Value(self, ir.Constant(ir.VectorType(DOUBLE, len(lanes)), None))


def _put(array: _Numbers, i: int, value: _Value) -> None:
    """Write lanes side by side."""
    array.lines.store(array.data, i * value.value.type.count, value.value)


class _Value:
    """Result of an instruction: a double, or lanes of them."""

    __slots__ = ("lines", "value")

    def __init__(self, lines: _Lines, value: Any) -> None:
        self.lines, self.value = lines, value

    def __add__(self, other: Any) -> _Value:
        return self.lines.operate("fadd", self, other)

    def __radd__(self, other: Any) -> _Value:
        return self.lines.operate("fadd", other, self)

    def __sub__(self, other: Any) -> _Value:
        return self.lines.operate("fsub", self, other)

    def __rsub__(self, other: Any) -> _Value:
        return self.lines.operate("fsub", other, self)

    def __mul__(self, other: Any) -> _Value:
        return self.lines.operate("fmul", self, other)

    def __rmul__(self, other: Any) -> _Value:
        return self.lines.operate("fmul", other, self)

    def __truediv__(self, other: Any) -> _Value:
        return self.lines.operate("fdiv", self, other)

    def __rtruediv__(self, other: Any) -> _Value:
        return self.lines.operate("fdiv", other, self)

    def __neg__(self) -> _Value:
        return _Value(self.lines, self.lines.builder.fneg(self.value))


class _Numbers:
    """An array of doubles."""

    __slots__ = ("lines", "data", "_steps", "_strided")

    def __init__(self, lines: _Lines, kind: Any, value: Any) -> None:
        array = lines.context.make_array(kind)(lines.context, lines.builder, value)
        self.lines, self.data, self._strided = lines, array.data, kind.layout != "C"
        self._steps = cgutils.unpack_tuple(lines.builder, array.strides)

    def _place(self, index: Any) -> Any:
        builder, indices = self.lines.builder, index if isinstance(index, tuple) else (index,)
        if not self._strided and len(indices) == 1:
            return self.lines.at(self.data, indices[0])
        offset: Any = ir.Constant(INDEX, 0 if self._strided else 8 * indices[-1])
        for i, step in zip(indices if self._strided else indices[:-1], self._steps, strict=False):
            offset = builder.add(offset, builder.mul(ir.Constant(INDEX, i), step))
        raw = builder.gep(builder.bitcast(self.data, ir.IntType(8).as_pointer()), [offset])
        return builder.bitcast(raw, DOUBLE.as_pointer())

    def __getitem__(self, index: Any) -> _Value:
        return _Value(self.lines, self.lines.builder.load(self._place(index)))

    def __setitem__(self, index: Any, value: Any) -> None:
        self.lines.builder.store(self.lines.value(value), self._place(index))


class _Model:
    """A NamedTuple of numbers and arrays, or a handle of one."""

    def __init__(self, lines: _Lines, kind: Any, value: Any) -> None:
        self._lines, self._kind, self._value = lines, kind, value

    def __getattr__(self, name: str) -> Any:
        lines, kind = self._lines, self._kind
        held = kind.content if isinstance(kind, HandleType) else kind
        place = held.fields.index(name)
        if isinstance(kind, HandleType):
            value = field_of(lines.context, lines.builder, kind, self._value, name)
        else:
            value = lines.builder.extract_value(self._value, place)
        found = lines.known(held[place], value)
        setattr(self, name, found)
        return found
