"""Elementary functions of numbers or lanes, the same bits for both: what printed expressions call, as machine instructions.

Sine, cosine, tanh, rounding, signs and comparisons are instructions on whole registers. Other functions are those of the C
library, called once for every lane.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import overload

from doorman.numba_types.lanes import builtin


def _constant(kind: Any, value: float) -> Any:
    return ir.Constant(kind, [value] * kind.count if isinstance(kind, ir.VectorType) else value)


def _call(builder: Any, name: str, *values: Any) -> Any:
    """Call of an intrinsic of LLVM that takes whole registers."""
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


_SIN = (1.58962301576546568060e-10, -2.50507477628578072866e-8, 2.75573136213857245213e-6,
        -1.98412698295895385996e-4, 8.33333333332211858878e-3, -1.66666666666666307295e-1)  # fmt: skip
_COS = (-1.13585365213876817300e-11, 2.08757008419747316778e-9, -2.75573141792967388112e-7,
        2.48015872888517045348e-5, -1.38888888888730564116e-3, 4.16666666666665929218e-2)  # fmt: skip
_HALF_PI = (1.57079632673412561417e00, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
"""π/2 in three parts, the first two with trailing zeros (Cody and Waite)."""


def _sincos(builder: Any, x: Any) -> tuple[Any, Any]:
    """Range reduction by multiples of π/2 in three parts, minimax polynomials of Moshier's Cephes library."""

    def constant(number: float) -> Any:
        return _constant(x.type, number)

    def fma(a: Any, b: Any, c: Any) -> Any:
        return _call(builder, "fma", a, b, c)

    def holds(comparison: str, a: Any, number: float) -> Any:
        return builder.fcmp_ordered(comparison, a, constant(number))

    turns = _call(builder, "rint", builder.fmul(x, constant(2.0 / np.pi)))
    rest = x
    for part in _HALF_PI:
        rest = fma(turns, constant(-part), rest)
    square = builder.fmul(rest, rest)
    sine = fma(builder.fmul(rest, square), _polynomial(builder, _SIN, square), rest)
    cosine = fma(
        builder.fmul(square, square), _polynomial(builder, _COS, square), fma(square, constant(-0.5), constant(1.0))
    )
    quarter = builder.fmul(turns, constant(0.25))
    quadrant = builder.fsub(quarter, _call(builder, "floor", quarter))  # 0, ¼, ½ or ¾
    odd = builder.or_(holds("==", quadrant, 0.25), holds("==", quadrant, 0.75))
    first, second = builder.select(odd, cosine, sine), builder.select(odd, sine, cosine)
    first = builder.select(holds(">=", quadrant, 0.5), builder.fneg(first), first)
    middle = builder.and_(holds(">=", quadrant, 0.25), holds("<=", quadrant, 0.5))
    return first, builder.select(middle, builder.fneg(second), second)


_EXP = tuple(1.0 / math.factorial(k) for k in range(13, -1, -1))
_LN2 = (6.93145751953125e-1, 1.42860682030941723212e-6)
"""ln 2 in two parts, the first with trailing zeros (Cody and Waite)."""
_TANH_NUMERATOR = (-9.64399179425052238628e-1, -9.92877231001918586564e1, -1.61468768441708447952e3)
_TANH_DENOMINATOR = (1.0, 1.12811678491632931402e2, 2.23548839060100448583e3, 4.84406305325125486048e3)
_TANH_RATIONAL = 0.625
"""Up to here by the rational approximation of Moshier's Cephes library, beyond by the exponential function."""
_TANH_ONE = 20.0
"""1, rounded, from here on."""


def _tanh(builder: Any, x: Any) -> Any:
    """Hyperbolic tangent, good to 2 ulp."""
    whole = ir.VectorType(ir.IntType(64), x.type.count) if isinstance(x.type, ir.VectorType) else ir.IntType(64)

    def constant(number: float) -> Any:
        return _constant(x.type, number)

    def fma(a: Any, b: Any, c: Any) -> Any:
        return _call(builder, "fma", a, b, c)

    size = _call(builder, "fabs", x)
    exponent = builder.select(
        builder.fcmp_ordered(">", size, constant(_TANH_ONE)), constant(2.0 * _TANH_ONE), builder.fadd(size, size)
    )
    powers = _call(builder, "rint", builder.fmul(exponent, constant(1.0 / math.log(2.0))))
    rest = fma(powers, constant(-_LN2[1]), fma(powers, constant(-_LN2[0]), exponent))
    bits = builder.add(builder.fptosi(powers, whole), _constant(whole, 1023))
    doubled = builder.bitcast(builder.shl(bits, _constant(whole, 52)), x.type)
    exponential = builder.fmul(_polynomial(builder, _EXP, rest), doubled)
    square = builder.fmul(x, x)
    small = builder.fcmp_ordered("<=", size, constant(_TANH_RATIONAL))
    one = _call(builder, "copysign", constant(1.0), x)
    numerator = builder.fmul(builder.fmul(x, square), _polynomial(builder, _TANH_NUMERATOR, square))
    above = builder.select(small, numerator, builder.fmul(one, constant(-2.0)))
    denominator = _polynomial(builder, _TANH_DENOMINATOR, square)
    below = builder.select(small, denominator, builder.fadd(exponential, constant(1.0)))
    result = builder.fadd(builder.select(small, x, one), builder.fdiv(above, below))
    return builder.select(builder.fcmp_unordered("uno", x, x), x, result)


def _whole(name: str) -> Callable[..., Any]:
    return lambda builder, *values: _call(builder, name, *values)


def _by_lane(name: str) -> Callable[..., Any]:
    """Instructions that call a function of the C library for every lane."""

    def generate(builder: Any, *values: Any) -> Any:
        double, kind = ir.DoubleType(), values[0].type
        function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(double, [double] * len(values)), name)
        if not isinstance(kind, ir.VectorType):
            return builder.call(function, values)
        result = ir.Constant(kind, ir.Undefined)
        for i in range(kind.count):
            index = ir.Constant(ir.IntType(32), i)
            lane = builder.call(function, [builder.extract_element(value, index) for value in values])
            result = builder.insert_element(result, lane, index)
        return result

    return generate


def _truth(builder: Any, holds: Any, kind: Any) -> Any:
    """1 where it holds, else 0."""
    return builder.select(holds, _constant(kind, 1.0), _constant(kind, 0.0))


def _is_true(builder: Any, x: Any) -> Any:
    return builder.fcmp_unordered("!=", x, _constant(x.type, 0.0))


def _compared(comparison: str) -> Callable[..., Any]:
    """Instructions of a comparison; NaN holds none but !=."""

    def generate(builder: Any, x: Any, y: Any) -> Any:
        compare = builder.fcmp_unordered if comparison == "!=" else builder.fcmp_ordered
        return _truth(builder, compare(comparison, x, y), x.type)

    return generate


def _sign(builder: Any, x: Any) -> Any:
    zero = _constant(x.type, 0.0)
    below = builder.select(builder.fcmp_ordered("<", x, zero), _constant(x.type, -1.0), x)
    return builder.select(builder.fcmp_ordered(">", x, zero), _constant(x.type, 1.0), below)


WORDS: dict[str, Callable[..., Any]] = {
    "sincos": _sincos, "tanh": _tanh, "square_root": _whole("sqrt"), "absolute": _whole("fabs"),
    "rounded_down": _whole("floor"), "rounded_up": _whole("ceil"), "with_sign_of": _whole("copysign"), "sign": _sign,
    "larger": lambda builder, x, y: builder.select(builder.fcmp_ordered("<", x, y), y, x),  # NaN in the first stays
    "smaller": lambda builder, x, y: builder.select(builder.fcmp_ordered(">", x, y), y, x),
    "kept_if": lambda builder, x, y: builder.select(_is_true(builder, x), y, _constant(y.type, 0.0)),
    "less": _compared("<"), "less_or_equal": _compared("<="), "equal": _compared("=="), "different": _compared("!="),
    "negated": lambda builder, x: _truth(builder, builder.not_(_is_true(builder, x)), x.type),
    "both": lambda builder, x, y: _truth(builder, builder.and_(_is_true(builder, x), _is_true(builder, y)), x.type),
    "either": lambda builder, x, y: _truth(builder, builder.or_(_is_true(builder, x), _is_true(builder, y)), x.type),
    "exponential": _by_lane("exp"), "exponential_less_one": _by_lane("expm1"), "logarithm": _by_lane("log"),
    "logarithm_of_more_than_one": _by_lane("log1p"), "power": _by_lane("pow"), "hypotenuse": _by_lane("hypot"),
    "remainder": _by_lane("fmod"), "error_function": _by_lane("erf"), "tangent": _by_lane("tan"),
    "arcsine": _by_lane("asin"), "arccosine": _by_lane("acos"), "arctangent": _by_lane("atan"),
    "angle_of": _by_lane("atan2"), "hyperbolic_sine": _by_lane("sinh"), "hyperbolic_cosine": _by_lane("cosh"),
    "area_sine": _by_lane("asinh"), "area_cosine": _by_lane("acosh"), "area_tangent": _by_lane("atanh"),
}  # fmt: skip
"""Generators of instructions by name: of a builder of LLVM's, and values of one type."""


def sincos(x: Any) -> tuple[Any, Any]:
    """Sine and cosine [rad], good to 1 ulp of 1 for x between ±1e5; in kernels the instructions of printed expressions."""
    return np.sin(x), np.cos(x)


@builtin
def _sincos_of_number(typingctx: Any, x: Any) -> Any:
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        both = _sincos(builder, context.cast(builder, args[0], sig.args[0], types.float64))
        return context.make_tuple(builder, sig.return_type, both)

    return types.UniTuple(types.float64, 2)(x), build


@overload(sincos, strict=False)
def _compiled_sincos(x: Any) -> Any:
    return lambda x: _sincos_of_number(x)
