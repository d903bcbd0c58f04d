r"""One node of a Riccati sweep, as vector code for the sizes at hand.

The dynamics' rows are [A | e | B] with the defect e, the value function's [V_xx | V_x]: one product carries Hessian and
gradient together. The inputs' rows [Q_ux | Q_u | Q_uu] are eliminated by :math:`Q_{uu} = U^T D U` with U unit upper triangular
and D diagonal, which has no roots. With R the rows in the course of the elimination and L = D⁻¹R:

.. math:: V_{xx} = Q_{xx} - R_x^T L_x,\quad V_x = Q_x - R_x^T L_e,\quad [K | k] = -U^{-1}[L_x | L_e]

V_xx and Q_uu are symmetric: only their upper halves are computed. The last m states may be integrators of the last m inputs,
:math:`x^+ = x + \Delta t\,u` without a defect (an arm's joints): their rows of A and B are not multiplied but copied.

Products are made tile by tile (`tiles`), so that sums stay in registers. U and D come first, number by number: each pivot waits
for the one before, and vectors would make that wait longer.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from llvmlite import ir
from numba.core import types

from doorman.numba_types.emitter import DOUBLE
from doorman.numba_types.handles import HandleType
from doorman.numba_types.lanes import builtin
from doorman.ocp.solvers.sweeps.tiles import CHUNKS, ROWS, WIDTH, Tiles, parts

_SMALLEST_PIVOT = 1e-14


class _Shape(NamedTuple):
    """Dimensions of a node."""

    states: int
    inputs: int
    integrators: int
    narrow: int
    wide: int

    @property
    def moving(self) -> int:
        """States that are no integrators."""
        return self.states - self.integrators

    @property
    def free(self) -> int:
        """Inputs that no state integrates."""
        return self.inputs - self.integrators

    @property
    def first_input(self) -> int:
        """Column of the first input in [x | 1 | u]."""
        return self.states + 1

    @property
    def narrow_chunks(self) -> int:
        """Vectors in [x | 1]."""
        return -(-(self.states + 1) // WIDTH)

    @property
    def wide_chunks(self) -> int:
        """Vectors in [x | 1 | u]."""
        return -(-(self.states + 1 + self.inputs) // WIDTH)


class _Memory(NamedTuple):
    """Pointers to the node's numbers, see `eliminate_inputs`."""

    jacobian: Any
    value: Any
    base_x: Any
    base_u: Any
    gains: Any
    factors: Any
    values: Any
    rows: Any
    scaled: Any


@builtin
def eliminate_inputs(
    typingctx: Any, sizes: Any, node: Any, time_step: Any, jacobians: Any, value: Any, base_x: Any, base_u: Any,
    gains: Any, factors: Any, values: Any, rows: Any, scaled: Any,
) -> Any:  # fmt: skip
    """Value function of node k from that of node k + 1, and the policy between them."""
    held = sizes.content if isinstance(sizes, HandleType) else sizes
    shape = _Shape(*(len(held[held.fields.index(name)]) for name in ("states", "inputs", *_Shape._fields[2:])))
    arrays = (jacobians, value, base_x, base_u, gains, factors, values, rows, scaled)

    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        emit = Tiles(context, builder)
        k = context.cast(builder, args[1], sig.args[1], types.intp)
        memory = _Memory(*(emit.data(kind, array) for kind, array in zip(sig.args[3:], args[3:], strict=True)))
        memory = memory._replace(
            jacobian=emit.offset(memory.jacobian, k, shape.states * shape.wide),
            gains=emit.offset(memory.gains, k, shape.inputs * shape.narrow),
            factors=emit.offset(memory.factors, k, shape.inputs * factors_width(shape.inputs)),
            values=emit.offset(memory.values, k, shape.states * shape.narrow),
        )
        step = context.cast(builder, args[2], sig.args[2], types.float64)
        return _Node(emit, shape, memory, emit.spread(step, WIDTH)).eliminate()

    return types.boolean(sizes, node, time_step, *arrays), build


class _Node:
    """Code of one node, phase by phase."""

    def __init__(self, emit: Tiles, shape: _Shape, memory: _Memory, step: Any) -> None:
        self.emit, self.shape, self.memory, self.step = emit, shape, memory, step
        self.product = emit.scratch(shape.states * shape.wide)

    def eliminate(self) -> Any:
        """All phases; whether Q_uu is positive definite."""
        self.multiply_value()
        self.set_input_rows()
        unit, inverses, positive = self.factorize()
        self.reduce_input_rows(unit, inverses)
        self.set_value()
        self.mirror_value()
        self.set_gains()
        return positive

    def multiply_value(self) -> None:
        """Product V [A | e | B], with V_x in the column of e."""
        emit, shape, memory = self.emit, self.shape, self.memory
        for rows in parts(0, shape.states, ROWS):
            for chunks in parts(0, shape.wide_chunks, CHUNKS):
                totals = emit.add_products(
                    [[self.integrated(i, chunk) for chunk in chunks] for i in rows], shape.moving,
                    (memory.value, lambda i: i * shape.narrow, 1), (memory.jacobian, shape.wide), rows, chunks, emit.plus,
                )  # fmt: skip
                self.put(self.product, shape.wide, rows, chunks, totals)

    def integrated(self, i: int, chunk: int) -> Any:
        """Part of the product's row i that needs none: V_x, and the columns of integrators and their inputs."""
        emit, shape = self.emit, self.shape
        row, taken = emit.at(self.memory.value, i * shape.narrow), range(WIDTH * chunk, WIDTH * chunk + WIDTH)
        plain = emit.columns(row, shape.narrow, [c if shape.moving <= c <= shape.states else None for c in taken])
        first, last = shape.first_input + shape.free, shape.first_input + shape.inputs
        rates = [shape.moving + c - first if first <= c < last else None for c in taken]
        if all(c is None for c in rates):
            return plain
        return emit.plus(plain, self.step, emit.columns(row, shape.narrow, rates))

    def set_input_rows(self) -> None:
        """Rows [Q_ux | Q_u | Q_uu] into `rows`."""
        emit, shape, memory = self.emit, self.shape, self.memory
        for rows in parts(0, shape.free, ROWS):
            for chunks in parts(0, shape.wide_chunks, CHUNKS):
                totals = emit.add_products(
                    [[emit.vector(memory.base_u, b * shape.wide + WIDTH * chunk) for chunk in chunks] for b in rows],
                    shape.moving, (memory.jacobian, lambda b: shape.first_input + b, shape.wide),
                    (self.product, shape.wide), rows, chunks, emit.plus,
                )  # fmt: skip
                self.put(memory.rows, shape.wide, rows, chunks, totals)
        for b in range(shape.free, shape.inputs):
            state = shape.moving + b - shape.free
            for place in range(0, WIDTH * shape.wide_chunks, WIDTH):
                share = emit.vector(self.product, state * shape.wide + place)
                total = emit.plus(emit.vector(memory.base_u, b * shape.wide + place), self.step, share)
                emit.store(memory.rows, b * shape.wide + place, total)
        emit.barrier()

    def factorize(self) -> tuple[dict[tuple[int, int], Any], list[Any], Any]:
        """U into `factors` and `scaled`, with D on the diagonal: U above it, the inverses of D, and whether all are positive."""
        emit, shape, memory, builder = self.emit, self.shape, self.memory, self.emit.builder
        nu, width = shape.inputs, factors_width(shape.inputs)
        positive, unit, inverses = ir.Constant(ir.IntType(1), 1), {}, []
        left = {
            (a, b): emit.scalar(memory.rows, a * shape.wide + shape.first_input + b)
            for a in range(nu)
            for b in range(a, nu)
        }
        for a in range(nu):
            pivot = left[a, a]
            enough = builder.fcmp_ordered(">", pivot, ir.Constant(DOUBLE, _SMALLEST_PIVOT))
            positive = builder.and_(positive, enough)
            inverses.append(builder.fdiv(ir.Constant(DOUBLE, 1.0), pivot))
            emit.store(memory.factors, a * width + a, pivot)
            for b in range(a + 1, nu):
                unit[a, b] = emit.multiply(left[a, b], inverses[a])
                for c in range(b, nu):
                    left[b, c] = emit.minus(left[b, c], unit[a, b], left[a, c])
                emit.store(memory.factors, a * width + b, unit[a, b])
        emit.barrier()
        return unit, inverses, positive

    def reduce_input_rows(self, unit: dict[tuple[int, int], Any], inverses: list[Any]) -> None:
        """R and L in the columns of states and gradient; the part of U that belongs behind L."""
        emit, shape, memory = self.emit, self.shape, self.memory
        width, chunks = factors_width(shape.inputs), range(shape.narrow_chunks)
        for b in range(shape.inputs):
            row = [emit.vector(memory.rows, b * shape.wide + WIDTH * chunk) for chunk in chunks]
            for a in range(b):
                share = emit.filled(memory.factors, a * width + b)
                row = [
                    emit.minus(total, share, emit.vector(memory.rows, a * shape.wide + WIDTH * chunk))
                    for chunk, total in zip(chunks, row, strict=True)
                ]
            inverse = emit.spread(inverses[b], WIDTH)
            for chunk, total in zip(chunks, row, strict=True):
                emit.store(memory.rows, b * shape.wide + WIDTH * chunk, total)
                emit.store(memory.scaled, b * shape.wide + WIDTH * chunk, emit.multiply(total, inverse))
            for c in range(b + 1, shape.inputs):
                emit.store(memory.scaled, b * shape.wide + shape.first_input + c, unit[b, c])
            emit.barrier()

    def set_value(self) -> None:
        """Upper half of V_xx, and V_x, into `value` and `values`."""
        emit, shape, memory = self.emit, self.shape, self.memory
        for first in range(0, shape.states, WIDTH):
            block = range(first, min(first + WIDTH, shape.states))
            for rows in parts(block.start, block.stop, ROWS):
                for chunks in parts(first // WIDTH, shape.narrow_chunks, CHUNKS):
                    totals = self.state_rows(rows, chunks)
                    totals = emit.add_products(
                        totals, shape.inputs, (memory.rows, lambda i: i, shape.wide), (memory.scaled, shape.wide),
                        rows, chunks, emit.minus,
                    )  # fmt: skip
                    self.put(memory.values, shape.narrow, rows, chunks, totals, last=False)
                    self.put(memory.value, shape.narrow, rows, chunks, totals)

    def state_rows(self, rows: range, chunks: range) -> list[list[Any]]:
        """Tile of [Q_xx | Q_x]."""
        emit, shape, memory = self.emit, self.shape, self.memory
        base = [[emit.vector(memory.base_x, i * shape.narrow + WIDTH * chunk) for chunk in chunks] for i in rows]
        moving = [i for i in rows if i < shape.moving]
        totals = emit.add_products(
            base[: len(moving)], shape.moving, (memory.jacobian, lambda i: i, shape.wide), (self.product, shape.wide),
            moving, chunks, emit.plus,
        )  # fmt: skip
        for i, line in list(zip(rows, base, strict=True))[len(moving) :]:
            shares = [emit.vector(self.product, i * shape.wide + WIDTH * chunk) for chunk in chunks]
            totals.append([emit.add(each, share) for each, share in zip(line, shares, strict=True)])
        return totals

    def mirror_value(self) -> None:
        """Blocks of V_xx below its diagonal, from those above."""
        emit, shape, memory = self.emit, self.shape, self.memory
        for first in range(WIDTH, shape.states, WIDTH):
            for other in range(0, first, WIDTH):
                lines = [emit.vector(memory.value, (other + i) * shape.narrow + first) for i in range(WIDTH)]
                for i, line in zip(range(first, shape.states), emit.transposed(lines), strict=False):
                    emit.store(memory.value, i * shape.narrow + other, line)
                    emit.store(memory.values, i * shape.narrow + other, line)
        emit.barrier()

    def set_gains(self) -> None:
        """Feedback [K | k] into `gains`, from the last input to the first."""
        emit, shape, memory = self.emit, self.shape, self.memory
        width = factors_width(shape.inputs)
        for chunks in parts(0, shape.narrow_chunks, CHUNKS):
            found: dict[int, list[Any]] = {}
            for b in reversed(range(shape.inputs)):
                lines = [emit.vector(memory.scaled, b * shape.wide + WIDTH * chunk) for chunk in chunks]
                row = [emit.builder.fneg(line) for line in lines]
                for a in range(b + 1, shape.inputs):
                    share = emit.filled(memory.factors, b * width + a)
                    row = [emit.minus(total, share, other) for total, other in zip(row, found[a], strict=True)]
                found[b] = row
                for chunk, total in zip(chunks, row, strict=True):
                    emit.store(memory.gains, b * shape.narrow + WIDTH * chunk, total)

    def put(
        self, target: Any, width: int, rows: range, chunks: range, totals: list[list[Any]], last: bool = True
    ) -> None:
        """Write a tile; loads that follow the last writing stay behind it."""
        for i, line in zip(rows, totals, strict=True):
            for chunk, total in zip(chunks, line, strict=True):
                self.emit.store(target, i * width + WIDTH * chunk, total)
        if last:
            self.emit.barrier()


def factors_width(nu: int) -> int:
    """Length of a row of the factors: nu, padded."""
    return -(-nu // 8) * 8
