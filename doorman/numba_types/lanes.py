"""Vectors of doubles as a numba type, for whole rows of a matrix.

`load` reads consecutive doubles of an array as one value of type `Lanes`, `store` writes it back; in between it takes part in
sums, differences and products with other such values and with floats. LLVM maps it to the machine's vector registers whatever
its width.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic, models, register_model
from numba.core.imputils import lower_builtin, lower_cast
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

from doorman.numba_types.emitter import FLAGS, Emitter


def builtin(generate: Callable[..., Any]) -> Any:
    """A function of compiled code whose instructions `generate` writes; typed as Any, as the types are numba's."""
    return intrinsic(generate)


class Lanes(types.Type):
    """numba's type of a vector of doubles."""

    def __init__(self, width: int) -> None:
        self.width = width
        super().__init__(name=f"Lanes({width})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, dmm: Any, fe_type: Lanes) -> None:
        super().__init__(dmm, fe_type, ir.VectorType(ir.DoubleType(), fe_type.width))


@lower_cast(types.Float, Lanes)
def _float_to_lanes(context: Any, builder: Any, source: Any, target: Any, value: Any) -> Any:
    return Emitter(context, builder).spread(context.cast(builder, value, source, types.float64), target.width)


def _define(function: Any, method: str) -> None:
    """Teach numba one binary operator."""

    class Template(AbstractTemplate):
        def generic(self, args: Any, kws: Any) -> Any:
            lanes = [arg for arg in args if isinstance(arg, Lanes)]
            if len(args) == 2 and lanes and all(isinstance(arg, Lanes | types.Float) for arg in args):
                return signature(lanes[0], *args)
            return None

    infer_global(function)(Template)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        left, right = (
            context.cast(builder, value, source, sig.return_type) for value, source in zip(args, sig.args, strict=True)
        )
        return getattr(builder, method)(left, right, flags=FLAGS)

    for left, right in ((Lanes, Lanes), (Lanes, types.Float), (types.Float, Lanes)):
        lower_builtin(function, left, right)(build)


for _function, _method in (
    (operator.add, "fadd"), (operator.iadd, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"),
):  # fmt: skip
    _define(_function, _method)


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
def zero(typingctx: Any, width: Any) -> Any:
    """Lanes of zeros."""
    lanes = Lanes(len(width))

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return ir.Constant(ir.VectorType(ir.DoubleType(), lanes.width), None)

    return lanes(width), build
