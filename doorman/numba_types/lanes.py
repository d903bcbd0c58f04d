"""Vectors of doubles as a numba type: a formula written once runs on one number or on a register full of them.

`load` reads consecutive doubles of an array as one value of type `Lanes`, `store` writes it back; in between it takes part in
arithmetic with other such values and with floats. LLVM maps it to the machine's vector registers whatever its width. Two uses:
eight nodes of a horizon side by side, and whole rows of a matrix in a Riccati sweep.

Functions of `elementary` and `lane_functions` take either floats or lanes and compute the same bits for both.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic, models, overload, register_model
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typing.templates import AbstractTemplate, infer_global, signature


def builtin(generate: Callable[..., Any]) -> Any:
    """A function of compiled code whose instructions `generate` writes; typed as Any, as the types are numba's."""
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


def row_pointer(context: Any, builder: Any, array_type: Any, array: Any, indices: Any, width: int) -> Any:
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
    """Consecutive doubles of an array as lanes."""
    lanes = Lanes(len(width))

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        indices = _indices(context, builder, sig.args[1], args[1])
        pointer = row_pointer(context, builder, sig.args[0], args[0], indices, lanes.width)
        return builder.load(pointer, align=8)

    return lanes(array, index, width), build


@builtin
def store(typingctx: Any, array: Any, index: Any, value: Any) -> Any:
    """Write lanes to consecutive doubles of an array."""
    if not isinstance(value, Lanes):
        return None

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        indices = _indices(context, builder, sig.args[1], args[1])
        pointer = row_pointer(context, builder, sig.args[0], args[0], indices, value.width)
        builder.store(args[2], pointer, align=8)
        return context.get_dummy_value()

    return types.void(array, index, value), build


@builtin
def broadcast(typingctx: Any, value: Any, width: Any) -> Any:
    """Lanes that all hold one number."""
    lanes = Lanes(len(width))

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return _broadcast(builder, context.cast(builder, args[0], sig.args[0], types.float64), lanes.width)

    return lanes(value, width), build


@builtin
def lane(typingctx: Any, value: Any, index: Any) -> Any:
    """One lane as a float."""

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.extract_element(
            args[0], builder.trunc(args[1], ir.IntType(32)) if args[1].type.width > 32 else args[1]
        )

    return types.float64(value, index), build


def zero(lanes: tuple[int, ...]) -> Any:
    """Zero in lanes, or as a float."""
    return 0.0


def get(array: Any, index: Any, lanes: tuple[int, ...]) -> Any:
    """Number of an array, or the lanes along its last axis if `lanes` is not empty; `index` leaves that axis out."""
    return array[index]


def put(array: Any, index: Any, value: Any) -> None:
    """Write a number, or lanes along the last axis."""
    array[index] = value


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
