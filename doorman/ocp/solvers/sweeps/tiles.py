"""Products of small matrices in tiles that fit the machine's registers, as generated vector code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from llvmlite import ir
from numba.core import cgutils

from doorman.numba_types.emitter import DOUBLE, INDEX, Emitter

WIDTH = 4
"""Doubles in a vector, on every machine: the memory of `doorman.ocp.solvers.memory.workspace` is padded to whole vectors."""

ROWS, CHUNKS = 4, 3
"""Rows and vectors of a tile: its sums, one row of the right factor and one number of the left one fit in 16 registers."""

_UNROLLED = 10
"""Longest sums that are written out; longer ones are loops, whose code stays in the processor's instruction cache."""


def parts(first: int, last: int, most: int) -> list[range]:
    """Ranges of at most `most` numbers that cover those from `first` to before `last`, of nearly equal length."""
    count = -(-(last - first) // most)
    ends = [first + (last - first) * i // count for i in range(count + 1)] if count > 0 else []
    return [range(start, stop) for start, stop in zip(ends[:-1], ends[1:], strict=True)]


class Tiles(Emitter):
    """Vector instructions on tiles of matrices of doubles in memory."""

    def __init__(self, context: Any, builder: Any) -> None:
        super().__init__(context, builder)
        self.zero = ir.Constant(ir.VectorType(DOUBLE, WIDTH), [0.0] * WIDTH)

    def scratch(self, size: int) -> Any:
        """Pointer to memory on the stack. LLVM does not know where it points, and so does not take it apart into registers."""
        memory: Any = cgutils.alloca_once(self.builder, ir.ArrayType(DOUBLE, size))  # type: ignore[no-untyped-call]
        memory.align = 64
        pointer = self.builder.bitcast(memory, DOUBLE.as_pointer())
        kind = ir.FunctionType(pointer.type, [pointer.type])
        return self.builder.asm(kind, "", "=r,0,~{memory}", [pointer], True)

    def barrier(self) -> None:
        """Keep loads behind this from moving before it: numbers that wait in registers for their turn spill others."""
        self.builder.asm(ir.FunctionType(ir.VoidType(), []), "", "~{memory}", [], True)

    def vector(self, pointer: Any, index: Any) -> Any:
        """Vector of `WIDTH` consecutive doubles."""
        return self.load(pointer, index, WIDTH)

    def scalar(self, pointer: Any, index: Any) -> Any:
        """One double."""
        return self.builder.load(self.at(pointer, index))

    def filled(self, pointer: Any, index: Any) -> Any:
        """Vector with one double of an array in all lanes."""
        return self.spread(self.scalar(pointer, index), WIDTH)

    def plus(self, total: Any, left: Any, right: Any) -> Any:
        """Sum total + left · right."""
        return self.add(total, self.multiply(left, right))

    def minus(self, total: Any, left: Any, right: Any) -> Any:
        """Difference total − left · right."""
        return self.subtract(total, self.multiply(left, right))

    def columns(self, row: Any, width: int, sources: Sequence[int | None]) -> Any:
        """Vector of the given columns of a row, 0 where none is given."""
        given = [(lane, column) for lane, column in enumerate(sources) if column is not None]
        starts = {column - lane for lane, column in given}
        start = min(starts, default=0)
        if len(starts) == 1 and 0 <= start <= width - WIDTH:
            lanes = [lane if column is not None else WIDTH for lane, column in enumerate(sources)]
            return self.pick(self.vector(row, start), lanes, self.zero)
        total = self.zero
        for lane, column in given:
            total = self.builder.insert_element(total, self.scalar(row, column), ir.Constant(ir.IntType(32), lane))
        return total

    def add_products(
        self, totals: list[list[Any]], count: int, left: tuple[Any, Callable[[int], int], int], right: tuple[Any, int],
        rows: Sequence[int], chunks: Sequence[int], combine: Callable[[Any, Any, Any], Any],
    ) -> list[list[Any]]:  # fmt: skip
        """Tile of a product, total ± Σ_j left[j] · right[j]."""
        builder = self.builder

        def turn(sums: list[list[Any]], j: Any) -> list[list[Any]]:
            def moved(base: int, step: int) -> Any:
                if isinstance(j, int):
                    return base + j * step
                return builder.add(ir.Constant(INDEX, base), builder.mul(j, ir.Constant(INDEX, step)))

            factors = [self.vector(right[0], moved(WIDTH * chunk, right[1])) for chunk in chunks]
            shares = [self.filled(left[0], moved(left[1](row), left[2])) for row in rows]
            return [
                [combine(each, share, factor) for each, factor in zip(line, factors, strict=True)]
                for line, share in zip(sums, shares, strict=True)
            ]

        if count <= _UNROLLED:
            for j in range(count):
                totals = turn(totals, j)
            return totals
        keep: Any = cgutils.alloca_once_value
        places = [[keep(builder, each) for each in line] for line in totals]
        with cgutils.for_range(builder, ir.Constant(INDEX, count)) as loop:
            sums = turn([[builder.load(place) for place in line] for line in places], loop.index)
            for line, targets in zip(sums, places, strict=True):
                for each, place in zip(line, targets, strict=True):
                    builder.store(each, place)
        return [[builder.load(place) for place in line] for line in places]

    def transposed(self, block: list[Any]) -> list[Any]:
        """Transpose of a square block."""
        half = WIDTH // 2
        while half:
            swapped = list(block)
            for i in (i for i in range(WIDTH) if not i & half):
                upper, lower = block[i], block[i + half]
                lanes = [lane if not lane & half else WIDTH + lane - half for lane in range(WIDTH)]
                swapped[i] = self.pick(upper, lanes, lower)
                lanes = [lane + half if not lane & half else WIDTH + lane for lane in range(WIDTH)]
                swapped[i + half] = self.pick(upper, lanes, lower)
            block, half = swapped, half // 2
        return block
