"""Vectors of doubles as a numba type: a formula written once runs on one number or on a register full of them.

`load` reads consecutive doubles of an array as one value of type `Lanes`, `store` writes it back; in between it takes part in
arithmetic with other such values and with floats. LLVM maps it to the machine's vector registers whatever its width. Two uses:
eight nodes of a horizon side by side, and whole rows of a matrix in a Riccati sweep.

`sincos`, `square_root`, `select_greater`, … take either floats or lanes and compute the same bits for both.
"""

from __future__ import annotations

import math
import operator
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic, models, overload, register_model
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typing.templates import AbstractTemplate, infer_global, signature


def builtin(generate: Callable[..., Any]) -> Any:
    """A function of compiled code whose instructions `generate` writes; typed as Any, as the types are numba's.

    Args:
        generate: As `numba.extending.intrinsic` takes it.
    """
    return intrinsic(generate)


_FLAGS = ("contract", "nsz", "arcp")
"""Sums keep their order: range reduction and results that are equal to the bit depend on it."""


class Lanes(types.Type):
    """numba's type of a vector of doubles."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"Lanes({width})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Lanes) -> None:
        super().__init__(dmm, fe_type, ir.VectorType(ir.DoubleType(), fe_type.width))


def _broadcast(builder: Any, value: Any, width: int) -> Any:
    vector = ir.VectorType(ir.DoubleType(), width)
    lane = builder.insert_element(ir.Constant(vector, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
    zeros = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
    return builder.shuffle_vector(lane, ir.Constant(vector, ir.Undefined), zeros)


@lower_cast(types.Float, Lanes)
def _float_to_lanes(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    return _broadcast(builder, context.cast(builder, value, source, types.float64), target.width)


@lower_cast(types.Integer, Lanes)
def _integer_to_lanes(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    return _broadcast(builder, context.cast(builder, value, source, types.float64), target.width)


def _define(function: Any, method: str) -> None:
    """Teach numba one binary operator."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            lanes = [arg for arg in args if isinstance(arg, Lanes)]
            if len(args) == 2 and lanes and all(isinstance(arg, (Lanes, types.Float, types.Integer)) for arg in args):
                return signature(lanes[0], *args)
            return None

    infer_global(function)(Template)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        left, right = (
            context.cast(builder, value, source, sig.return_type) for value, source in zip(args, sig.args, strict=True)
        )
        return getattr(builder, method)(left, right, flags=_FLAGS)

    for left in (Lanes, types.Float, types.Integer):
        for right in (Lanes, types.Float, types.Integer):
            if Lanes in (left, right):
                lower_builtin(function, left, right)(build)


for _function, _method in (
    (operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"), (operator.truediv, "fdiv"),
    (operator.iadd, "fadd"), (operator.isub, "fsub"), (operator.imul, "fmul"), (operator.itruediv, "fdiv"),
):  # fmt: skip
    _define(_function, _method)


@infer_global(operator.neg)
class _Negation(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        return signature(args[0], args[0]) if isinstance(args[0], Lanes) else None


@lower_builtin(operator.neg, Lanes)
def _negate(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    return builder.fneg(args[0])


def _row_pointer(context: Any, builder: Any, array_type: Any, array: Any, indices: Any, width: int) -> Any:
    """Pointer to consecutive doubles, as one to a vector."""
    view = context.make_array(array_type)(context, builder, array)
    pointer = cgutils.get_item_pointer(context, builder, array_type, view, indices, wraparound=False)
    return builder.bitcast(pointer, ir.VectorType(ir.DoubleType(), width).as_pointer())


def _indices(context: Any, builder: Any, kind: Any, value: Any) -> list[Any]:
    if isinstance(kind, types.Integer):
        return [context.cast(builder, value, kind, types.intp)]
    items = cgutils.unpack_tuple(builder, value)
    return [context.cast(builder, item, each, types.intp) for item, each in zip(items, kind, strict=True)]


@builtin
def load(typingctx: Any, array: Any, index: Any, width: Any) -> Any:
    """Consecutive doubles of an array as lanes.

    Args:
        typingctx: numba's typing context.
        array: C-contiguous array of doubles.
        index: Of the first one, an integer for each dimension.
        width: Tuple as long as there are lanes.
    """
    lanes = Lanes(len(width))

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        indices = _indices(context, builder, sig.args[1], args[1])
        pointer = _row_pointer(context, builder, sig.args[0], args[0], indices, lanes.width)
        return builder.load(pointer, align=8)

    return lanes(array, index, width), build


@builtin
def store(typingctx: Any, array: Any, index: Any, value: Any) -> Any:
    """Write lanes to consecutive doubles of an array.

    Args:
        typingctx: numba's typing context.
        array: C-contiguous array of doubles.
        index: Of the first one, an integer for each dimension.
        value: Lanes.
    """
    if not isinstance(value, Lanes):
        return None

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        indices = _indices(context, builder, sig.args[1], args[1])
        pointer = _row_pointer(context, builder, sig.args[0], args[0], indices, value.width)
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, index, value), build


@builtin
def broadcast(typingctx: Any, value: Any, width: Any) -> Any:
    """Lanes that all hold one number.

    Args:
        typingctx: numba's typing context.
        value: The number.
        width: Tuple as long as there are lanes.
    """
    lanes = Lanes(len(width))

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _broadcast(builder, context.cast(builder, args[0], sig.args[0], types.float64), lanes.width)

    return lanes(value, width), build


@builtin
def lane(typingctx: Any, value: Any, index: Any) -> Any:
    """One lane as a float.

    Args:
        typingctx: numba's typing context.
        value: Lanes.
        index: Of the lane.
    """

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_element(
            args[0], builder.trunc(args[1], ir.IntType(32)) if args[1].type.width > 32 else args[1]
        )

    return types.float64(value, index), build


def _constant(kind: Any, value: float) -> Any:
    return ir.Constant(kind, [value] * kind.count if isinstance(kind, ir.VectorType) else value)


def _call(builder: Any, name: str, *values: Any) -> Any:
    kind = values[0].type
    suffix = f"v{kind.count}f64" if isinstance(kind, ir.VectorType) else "f64"
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(kind, [kind] * len(values)), f"llvm.{name}.{suffix}"
    )
    return builder.call(function, values)


def _number(kind: Any) -> Any:
    """The type that a function of numbers or lanes computes in."""
    return kind if isinstance(kind, Lanes) else types.float64


@builtin
def _square_root(typingctx: Any, x: Any) -> Any:

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _call(builder, "sqrt", context.cast(builder, args[0], sig.args[0], sig.return_type))

    return _number(x)(x), build


@builtin
def _larger(typingctx: Any, x: Any, y: Any) -> Any:
    kind = x if isinstance(x, Lanes) else _number(y)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        a, b = (context.cast(builder, v, t, sig.return_type) for v, t in zip(args, sig.args, strict=True))
        return builder.select(builder.fcmp_ordered("<", a, b), b, a)

    return kind(x, y), build


_SIN = (1.58962301576546568060e-10, -2.50507477628578072866e-8, 2.75573136213857245213e-6,
        -1.98412698295895385996e-4, 8.33333333332211858878e-3, -1.66666666666666307295e-1)  # fmt: skip
_COS = (-1.13585365213876817300e-11, 2.08757008419747316778e-9, -2.75573141792967388112e-7,
        2.48015872888517045348e-5, -1.38888888888730564116e-3, 4.16666666666665929218e-2)  # fmt: skip
_HALF_PI = (1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
"""π/2 in three parts, the first two with trailing zeros (Cody and Waite)."""


@builtin
def _sincos(typingctx: Any, x: Any) -> Any:
    kind = _number(x)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = context.cast(builder, args[0], sig.args[0], kind)

        def constant(number: float) -> Any:
            return _constant(value.type, number)

        def fma(a: Any, b: Any, c: Any) -> Any:
            return _call(builder, "fma", a, b, c)

        def polynomial(coefficients: tuple[float, ...], z: Any) -> Any:
            result = constant(coefficients[0])
            for coefficient in coefficients[1:]:
                result = fma(result, z, constant(coefficient))
            return result

        turns = _call(builder, "rint", builder.fmul(value, constant(2.0 / np.pi)))
        rest = value
        for part in _HALF_PI:
            rest = fma(turns, constant(-part), rest)
        square = builder.fmul(rest, rest)
        sine = fma(builder.fmul(rest, square), polynomial(_SIN, square), rest)
        cosine = fma(builder.fmul(square, square), polynomial(_COS, square), fma(square, constant(-0.5), constant(1.0)))
        quarter = builder.fmul(turns, constant(0.25))
        quadrant = builder.fsub(quarter, _call(builder, "floor", quarter))  # 0, ¼, ½ or ¾
        odd = builder.or_(
            builder.fcmp_ordered("==", quadrant, constant(0.25)), builder.fcmp_ordered("==", quadrant, constant(0.75))
        )
        first, second = builder.select(odd, cosine, sine), builder.select(odd, sine, cosine)
        first = builder.select(builder.fcmp_ordered(">=", quadrant, constant(0.5)), builder.fneg(first), first)
        middle = builder.and_(
            builder.fcmp_ordered(">=", quadrant, constant(0.25)), builder.fcmp_ordered("<=", quadrant, constant(0.5))
        )
        second = builder.select(middle, builder.fneg(second), second)
        return context.make_tuple(builder, sig.return_type, (first, second))

    return types.UniTuple(kind, 2)(x), build


_EXP = tuple(1.0 / math.factorial(k) for k in range(13, -1, -1))
_LN2 = (6.93145751953125e-1, 1.42860682030941723212e-6)
"""ln 2 in two parts, the first with trailing zeros (Cody and Waite)."""
_TANH_NUMERATOR = (-9.64399179425052238628e-1, -9.92877231001918586564e1, -1.61468768441708447952e3)
_TANH_DENOMINATOR = (1.0, 1.12811678491632931402e2, 2.23548839060100448583e3, 4.84406305325125486048e3)
_TANH_RATIONAL = 0.625
"""Up to here by the rational approximation of Moshier's Cephes library, beyond by the exponential function."""
_TANH_ONE = 20.0
"""1, rounded, from here on."""


@builtin
def _tanh(typingctx: Any, x: Any) -> Any:
    kind = _number(x)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        value = context.cast(builder, args[0], sig.args[0], kind)
        whole = ir.VectorType(ir.IntType(64), value.type.count) if isinstance(kind, Lanes) else ir.IntType(64)

        def constant(number: float) -> Any:
            return _constant(value.type, number)

        def fma(a: Any, b: Any, c: Any) -> Any:
            return _call(builder, "fma", a, b, c)

        def polynomial(coefficients: tuple[float, ...], z: Any) -> Any:
            result = constant(coefficients[0])
            for coefficient in coefficients[1:]:
                result = fma(result, z, constant(coefficient))
            return result

        size = _call(builder, "fabs", value)
        exponent = builder.select(
            builder.fcmp_ordered(">", size, constant(_TANH_ONE)), constant(2.0 * _TANH_ONE), builder.fadd(size, size)
        )
        powers = _call(builder, "rint", builder.fmul(exponent, constant(1.0 / math.log(2.0))))
        rest = fma(powers, constant(-_LN2[1]), fma(powers, constant(-_LN2[0]), exponent))
        bits = builder.add(builder.fptosi(powers, whole), _constant(whole, 1023))
        doubled = builder.bitcast(builder.shl(bits, _constant(whole, 52)), value.type)
        exponential = builder.fmul(polynomial(_EXP, rest), doubled)
        square = builder.fmul(value, value)
        small = builder.fcmp_ordered("<=", size, constant(_TANH_RATIONAL))
        one = _call(builder, "copysign", constant(1.0), value)
        base = builder.select(small, value, one)
        above = builder.select(
            small,
            builder.fmul(builder.fmul(value, square), polynomial(_TANH_NUMERATOR, square)),
            builder.fmul(one, constant(-2.0)),
        )
        below = builder.select(small, polynomial(_TANH_DENOMINATOR, square), builder.fadd(exponential, constant(1.0)))
        result = builder.fadd(base, builder.fdiv(above, below))
        return builder.select(builder.fcmp_unordered("uno", value, value), value, result)

    return kind(x), build


def sincos(x: Any) -> tuple[Any, Any]:
    """Sine and cosine of a float or of lanes [rad], good to 1 ulp of 1 for x between ±1e5.

    Range reduction by multiples of π/2 in three parts, minimax polynomials of Moshier's Cephes library.

    Args:
        x: Float or lanes [rad].
    """
    return np.sin(x), np.cos(x)


def square_root(x: Any) -> Any:
    """Square root √x.

    Args:
        x: Float or lanes.
    """
    return np.sqrt(x)


def larger(x: Any, y: Any) -> Any:
    """The larger of two numbers, lane by lane; NaN in `x` stays.

    Args:
        x: Float or lanes.
        y: Float or lanes.
    """
    return max(x, y)


def tanh(x: Any) -> Any:
    """Hyperbolic tangent of a float or of lanes, good to 2 ulp.

    Args:
        x: Float or lanes.
    """
    return np.tanh(x)


def zero(lanes: tuple[int, ...]) -> Any:
    """Zero in lanes, or as a float.

    Args:
        lanes: Tuple as long as there are lanes; empty for a float.
    """
    return 0.0


def get(array: Any, index: Any, lanes: tuple[int, ...]) -> Any:
    """Number of an array, or the lanes along its last axis if `lanes` is not empty; `index` leaves that axis out.

    Args:
        array: C-contiguous array of doubles.
        index: Of the number, or of the lanes without the last axis.
        lanes: Tuple as long as there are lanes; empty for a float.
    """
    return array[index]


def put(array: Any, index: Any, value: Any) -> None:
    """Write a number, or lanes along the last axis.

    Args:
        array: C-contiguous array of doubles.
        index: Of the number, or of the lanes without the last axis.
        value: Float or lanes.
    """
    array[index] = value


@overload(sincos, strict=False)
def _compiled_sincos(x: Any) -> Any:
    return lambda x: _sincos(x)


@overload(square_root, strict=False)
def _compiled_square_root(x: Any) -> Any:
    return lambda x: _square_root(x)


@overload(larger, strict=False)
def _compiled_larger(x: Any, y: Any) -> Any:
    return lambda x, y: _larger(x, y)


@overload(zero, strict=False)
def _compiled_zero(lanes: Any) -> Any:
    return (lambda lanes: 0.0) if len(lanes) == 0 else (lambda lanes: broadcast(0.0, lanes))


@overload(get, strict=False)
def _compiled_get(array: Any, index: Any, lanes: Any) -> Any:
    if len(lanes) == 0:
        return lambda array, index, lanes: array[index]
    if isinstance(index, types.Integer):
        return lambda array, index, lanes: load(array, (index, 0), lanes)
    return lambda array, index, lanes: load(array, (*index, 0), lanes)


@overload(put, strict=False)
def _compiled_put(array: Any, index: Any, value: Any) -> Any:
    if not isinstance(value, Lanes):
        if array.ndim != (1 if isinstance(index, types.Integer) else len(index)):
            return None

        def assign(array: Any, index: Any, value: Any) -> None:
            array[index] = value

        return assign
    if isinstance(index, types.Integer):
        return lambda array, index, value: store(array, (index, 0), value)
    return lambda array, index, value: store(array, (*index, 0), value)


@overload(tanh, strict=False)
def _compiled_tanh(x: Any) -> Any:
    return lambda x: _tanh(x)


@builtin
def multiply_rows(
    typingctx: Any, matrix: Any, block: Any, count: Any, width: Any, vector: Any, out: Any, start: Any
) -> Any:
    """Product of a matrix's first rows with a vector, `out[start + i] = Σ_j matrix[block, i, j] vector[j]`.

    Args:
        typingctx: numba's.
        matrix: C-contiguous, shape (blocks, rows, columns).
        block: Which block.
        count: Number of rows to multiply; a tuple of that length unrolls the loop over them.
        width: Tuple as long as a row.
        vector: C-contiguous, of at least that length.
        out: C-contiguous, one-dimensional.
        start: First index written.
    """
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
        x = builder.load(_row_pointer(context, builder, sig.args[4], args[4], [first], n_columns), align=8)
        target = context.make_array(sig.args[5])(context, builder, args[5]).data

        def multiply(i: Any) -> None:
            place = [*index, i, first]
            row = builder.load(_row_pointer(context, builder, sig.args[0], args[0], place, n_columns), align=8)
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


@builtin
def clock(typingctx: Any) -> Any:
    """Time of the monotonic clock, the one of `time.monotonic` [s].

    Args:
        typingctx: numba's typing context.
    """

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
