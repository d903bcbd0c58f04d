"""Sine and cosine, tanh, square root and the larger of two: of numbers or lanes, the same bits for both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import overload

from doorman.numba_types.lanes import Lanes, builtin


def _constant(kind: Any, value: float) -> Any:
    return ir.Constant(kind, [value] * kind.count if isinstance(kind, ir.VectorType) else value)


def _call(builder: Any, name: str, *values: Any) -> Any:
    kind = values[0].type
    suffix = f"v{kind.count}f64" if isinstance(kind, ir.VectorType) else "f64"
    function = cgutils.get_or_insert_function(
        builder.module, ir.FunctionType(kind, [kind] * len(values)), f"llvm.{name}.{suffix}"
    )
    return builder.call(function, values)


def _polynomial(builder: Any, coefficients: Sequence[float], x: Any) -> Any:
    """Polynomial, the highest power first, by Estrin's scheme: pairs side by side, as a number waits for no other pair."""
    terms = [_constant(x.type, coefficient) for coefficient in reversed(coefficients)]
    while len(terms) > 1:
        pairs = [_call(builder, "fma", high, x, low) for low, high in zip(terms[::2], terms[1::2], strict=False)]
        terms = pairs + terms[len(terms) - len(terms) % 2 :]
        x = builder.fmul(x, x)
    return terms[0]


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

        turns = _call(builder, "rint", builder.fmul(value, constant(2.0 / np.pi)))
        rest = value
        for part in _HALF_PI:
            rest = fma(turns, constant(-part), rest)
        square = builder.fmul(rest, rest)
        sine = fma(builder.fmul(rest, square), _polynomial(builder, _SIN, square), rest)
        cosine = fma(
            builder.fmul(square, square), _polynomial(builder, _COS, square), fma(square, constant(-0.5), constant(1.0))
        )
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
            return _polynomial(builder, coefficients, z)

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
    """
    return np.sin(x), np.cos(x)


def square_root(x: Any) -> Any:
    """Square root √x."""
    return np.sqrt(x)


def larger(x: Any, y: Any) -> Any:
    """The larger of two numbers, lane by lane; NaN in `x` stays."""
    return max(x, y)


def tanh(x: Any) -> Any:
    """Hyperbolic tangent of a float or of lanes, good to 2 ulp."""
    return np.tanh(x)


INSTRUCTIONS = {"sincos": _sincos, "square_root": _square_root, "larger": _larger, "tanh": _tanh}
"""Generators of these functions' instructions."""


@overload(sincos, strict=False)
def _compiled_sincos(x: Any) -> Any:
    return lambda x: _sincos(x)


@overload(square_root, strict=False)
def _compiled_square_root(x: Any) -> Any:
    return lambda x: _square_root(x)


@overload(larger, strict=False)
def _compiled_larger(x: Any, y: Any) -> Any:
    return lambda x, y: _larger(x, y)


@overload(tanh, strict=False)
def _compiled_tanh(x: Any) -> Any:
    return lambda x: _tanh(x)
