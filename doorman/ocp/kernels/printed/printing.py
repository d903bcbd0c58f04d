"""CasADi SX expressions as lines of Python for kernels: an assignment for each value that is used more than once.

What is used once stands where it is used: numba takes its time for every variable.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca

from doorman.ocp.kernels.printed.operations import words_for

Read = Callable[[str, int], str]
"""Words that read an entry of a named argument."""
_DEEPEST = 12
"""Operations within each other in a line."""

Write = Callable[[int, int, str], str]
"""Line that writes a value to a nonzero of one of the results."""


def printed(where: str, arguments: Mapping[str, Any], results: Sequence[Any], read: Read, write: Write) -> list[str]:
    """Lines that compute expressions."""
    names = list(arguments)
    outputs = [f"result_{i}" for i in range(len(results))]
    function = ca.Function("printed", list(arguments.values()), ca.cse(list(results)), names, outputs)
    lines: list[str] = []
    values: dict[int, str] = {}
    depths: dict[int, int] = {}
    angles: dict[str, tuple[str, str]] = {}
    uses = _uses(function, where)
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        operands, target = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            lines.append(write(target[0], target[1], values[operands[0]]))
            continue
        depth = 1 + max((depths[operand] for operand in operands), default=0) if operation != ca.OP_INPUT else 0
        depths[target[0]] = 0
        if operation == ca.OP_CONST:
            values[target[0]] = _number(function.instruction_constant(k))
        elif operation == ca.OP_INPUT:
            values[target[0]] = _assigned(lines, read(names[operands[0]], operands[1]))
        elif operation in (ca.OP_SIN, ca.OP_COS):
            sine, cosine = _sine_and_cosine(lines, angles, values[operands[0]])
            values[target[0]] = sine if operation == ca.OP_SIN else cosine
        else:
            words = words_for(operation, where).format(*(values[operand] for operand in operands))
            inside = uses[k] == 1 and depth < _DEEPEST
            values[target[0]] = f"({words})" if inside else _assigned(lines, words)
            depths[target[0]] = depth if inside else 0
    return lines


def _uses(function: Any, where: str) -> Counter[int]:
    """How often the result of each instruction is written as an operand; CasADi uses the places of results again."""
    uses: Counter[int] = Counter()
    made: dict[int, int] = {}
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        if operation not in (ca.OP_INPUT, ca.OP_CONST):
            mentioned = 1 if operation in (ca.OP_OUTPUT, ca.OP_SIN, ca.OP_COS) else None
            words = "" if mentioned else words_for(operation, where)
            for i, operand in enumerate(function.instruction_input(k)[: 1 if mentioned else 2]):
                uses[made[operand]] += mentioned or words.count(f"{{{i}}}")
        if operation != ca.OP_OUTPUT:
            made[function.instruction_output(k)[0]] = k
    return uses


def _assigned(lines: list[str], words: str) -> str:
    """A new variable of that value."""
    name = f"v{len(lines)}"
    lines.append(f"{name} = {words}")
    return name


def _sine_and_cosine(lines: list[str], angles: dict[str, tuple[str, str]], angle: str) -> tuple[str, str]:
    """Variables of both, computed together and once."""
    if angle not in angles:
        angles[angle] = f"s{len(lines)}", f"c{len(lines)}"
        lines.append(f"{', '.join(angles[angle])} = sincos({angle})")
    return angles[angle]


def _number(value: float) -> str:
    if math.isfinite(value):
        return repr(value)
    return "np.nan" if math.isnan(value) else ("np.inf" if value > 0.0 else "-np.inf")
