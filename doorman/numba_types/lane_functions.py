"""Elementary functions of numbers or lanes, the same bits for both: what printed expressions call besides `elementary`.

Rounding, signs and comparisons are machine instructions on whole registers. Other functions are those of the C library, called
once for every lane.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types

from doorman.numba_types.lanes import Lanes, builtin


def _kind(arguments: tuple[Any, ...]) -> Any:
    """The type of the result: lanes if any argument is, else a double."""
    return next((argument for argument in arguments if isinstance(argument, Lanes)), types.float64)


def _cast(context: Any, builder: Any, sig: Any, args: Any) -> list[Any]:
    return [context.cast(builder, value, kind, sig.return_type) for value, kind in zip(args, sig.args, strict=True)]


def _constant(kind: Any, value: float) -> Any:
    return ir.Constant(kind, [value] * kind.count if isinstance(kind, ir.VectorType) else value)


def _unary(generate: Callable[[Any, Any], Any]) -> Any:
    def typed(typingctx: Any, x: Any) -> Any:
        def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return generate(builder, *_cast(context, builder, sig, args))

        return _kind((x,))(x), build

    return builtin(typed)


def _binary(generate: Callable[[Any, Any, Any], Any]) -> Any:
    def typed(typingctx: Any, x: Any, y: Any) -> Any:
        def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return generate(builder, *_cast(context, builder, sig, args))

        return _kind((x, y))(x, y), build

    return builtin(typed)


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


def _whole(name: str) -> Callable[..., Any]:
    """Instructions of an intrinsic of LLVM that takes whole registers."""

    def generate(builder: Any, *values: Any) -> Any:
        kind = values[0].type
        suffix = f"v{kind.count}f64" if isinstance(kind, ir.VectorType) else "f64"
        function = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(kind, [kind] * len(values)), f"llvm.{name}.{suffix}"
        )
        return builder.call(function, values)

    return generate


def _compared(comparison: str) -> Callable[..., Any]:
    """Instructions for 1 where a comparison holds, else 0; NaN holds none but !=."""

    def generate(builder: Any, x: Any, y: Any) -> Any:
        compare = builder.fcmp_unordered if comparison == "!=" else builder.fcmp_ordered
        return builder.select(compare(comparison, x, y), _constant(x.type, 1.0), _constant(x.type, 0.0))

    return generate


def _is_true(builder: Any, x: Any) -> Any:
    return builder.fcmp_unordered("!=", x, _constant(x.type, 0.0))


def _truth(builder: Any, holds: Any, like: Any) -> Any:
    return builder.select(holds, _constant(like.type, 1.0), _constant(like.type, 0.0))


def _smaller(builder: Any, x: Any, y: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", x, y), y, x)


def _sign(builder: Any, x: Any) -> Any:
    zero = _constant(x.type, 0.0)
    below = builder.select(builder.fcmp_ordered("<", x, zero), _constant(x.type, -1.0), x)
    return builder.select(builder.fcmp_ordered(">", x, zero), _constant(x.type, 1.0), below)


def _kept_if(builder: Any, condition: Any, x: Any) -> Any:
    return builder.select(_is_true(builder, condition), x, _constant(x.type, 0.0))


smaller = _binary(_smaller)
"""The smaller of two; NaN in the first stays."""
sign = _unary(_sign)
"""1, 0 or −1; NaN stays."""
kept_if = _binary(_kept_if)
"""The second where the first is not 0, else 0."""
absolute = _unary(_whole("fabs"))
rounded_down = _unary(_whole("floor"))
rounded_up = _unary(_whole("ceil"))
with_sign_of = _binary(_whole("copysign"))
"""Magnitude of the first, sign of the second."""

less = _binary(_compared("<"))
"""1 where it holds, else 0, as the others."""
less_or_equal = _binary(_compared("<="))
equal = _binary(_compared("=="))
different = _binary(_compared("!="))
negated = _unary(lambda builder, x: _truth(builder, builder.not_(_is_true(builder, x)), x))
both = _binary(lambda builder, x, y: _truth(builder, builder.and_(_is_true(builder, x), _is_true(builder, y)), x))
either = _binary(lambda builder, x, y: _truth(builder, builder.or_(_is_true(builder, x), _is_true(builder, y)), x))

exponential = _unary(_by_lane("exp"))
exponential_less_one = _unary(_by_lane("expm1"))
logarithm = _unary(_by_lane("log"))
logarithm_of_more_than_one = _unary(_by_lane("log1p"))
power = _binary(_by_lane("pow"))
hypotenuse = _binary(_by_lane("hypot"))
remainder = _binary(_by_lane("fmod"))
error_function = _unary(_by_lane("erf"))
tangent = _unary(_by_lane("tan"))
arcsine = _unary(_by_lane("asin"))
arccosine = _unary(_by_lane("acos"))
arctangent = _unary(_by_lane("atan"))
angle_of = _binary(_by_lane("atan2"))
"""atan2(y, x)."""
hyperbolic_sine = _unary(_by_lane("sinh"))
hyperbolic_cosine = _unary(_by_lane("cosh"))
area_sine = _unary(_by_lane("asinh"))
area_cosine = _unary(_by_lane("acosh"))
area_tangent = _unary(_by_lane("atanh"))
