"""Vector instructions of generated code, for functions whose loops over a problem's sizes are unrolled while it is written."""

from __future__ import annotations

from typing import Any

from llvmlite import ir

DOUBLE = ir.DoubleType()
INDEX = ir.IntType(64)
FLAGS = ("contract", "nsz", "arcp")
"""Sums keep their order: range reduction and results that are equal to the bit depend on it."""


class Emitter:
    """Vector instructions on C-contiguous arrays of doubles."""

    def __init__(self, context: Any, builder: Any) -> None:
        self.context, self.builder = context, builder

    def data(self, kind: Any, array: Any) -> Any:
        """Pointer to an array's first number."""
        return self.context.make_array(kind)(self.context, self.builder, array).data

    def offset(self, pointer: Any, index: Any, size: int) -> Any:
        """Pointer to block `index` of blocks of `size` numbers."""
        return self.builder.gep(pointer, [self.builder.mul(index, ir.Constant(index.type, size))])

    def at(self, pointer: Any, index: Any) -> Any:
        """Pointer to a double."""
        return self.builder.gep(pointer, [ir.Constant(INDEX, index) if isinstance(index, int) else index])

    def load(self, pointer: Any, start: Any, width: int) -> Any:
        """Vector of consecutive numbers of an array."""
        return self.builder.load(
            self.builder.bitcast(self.at(pointer, start), ir.VectorType(DOUBLE, width).as_pointer()), align=8
        )

    def store(self, pointer: Any, start: int, value: Any) -> None:
        """Write a vector, or one number, at `start`."""
        self.builder.store(value, self.builder.bitcast(self.at(pointer, start), value.type.as_pointer()), align=8)

    def spread(self, value: Any, width: int) -> Any:
        """Vector with a number in all lanes."""
        one = ir.VectorType(DOUBLE, 1)
        first = self.builder.insert_element(ir.Constant(one, ir.Undefined), value, ir.Constant(ir.IntType(32), 0))
        return self.pick(first, [0] * width)

    def pick(self, value: Any, lanes: list[int], other: Any = None) -> Any:
        """Vector of the given lanes of one vector, or of two in a row."""
        other = ir.Constant(value.type, ir.Undefined) if other is None else other
        mask = ir.Constant(ir.VectorType(ir.IntType(32), len(lanes)), lanes)
        return self.builder.shuffle_vector(value, other, mask)

    def add(self, left: Any, right: Any) -> Any:
        """Sum, lane by lane."""
        return self.builder.fadd(left, right, flags=FLAGS)

    def subtract(self, left: Any, right: Any) -> Any:
        """Difference, lane by lane."""
        return self.builder.fsub(left, right, flags=FLAGS)

    def multiply(self, left: Any, right: Any) -> Any:
        """Product, lane by lane."""
        return self.builder.fmul(left, right, flags=FLAGS)
