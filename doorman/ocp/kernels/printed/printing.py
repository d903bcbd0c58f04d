"""CasADi SX expressions as straight lines of Python: an assignment for each operation."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import casadi as ca

from doorman.ocp.kernels.printed.operations import words_for

Read = Callable[[str, int], str]
"""Words that read an entry of a named argument."""
Write = Callable[[int, int, str], str]
"""Line that writes a value to a nonzero of one of the results."""


def printed(where: str, arguments: Mapping[str, Any], results: Sequence[Any], read: Read, write: Write) -> list[str]:
    """Lines that compute expressions."""
    names = list(arguments)
    outputs = [f"result_{i}" for i in range(len(results))]
    function = ca.Function("printed", list(arguments.values()), ca.cse(list(results)), names, outputs)
    lines: list[str] = []
    values: dict[int, str] = {}
    angles: dict[str, tuple[str, str]] = {}
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        operands, target = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            lines.append(write(target[0], target[1], values[operands[0]]))
            continue
        if operation == ca.OP_CONST:
            values[target[0]] = _number(function.instruction_constant(k))
        elif operation == ca.OP_INPUT:
            values[target[0]] = _assigned(lines, read(names[operands[0]], operands[1]))
        elif operation in (ca.OP_SIN, ca.OP_COS):
            sine, cosine = _sine_and_cosine(lines, angles, values[operands[0]])
            values[target[0]] = sine if operation == ca.OP_SIN else cosine
        else:
            words = words_for(operation, where).format(*(values[operand] for operand in operands))
            values[target[0]] = _assigned(lines, words)
    return lines


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
