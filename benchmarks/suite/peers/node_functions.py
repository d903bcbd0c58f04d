"""CasADi functions of one node, generated as C, compiled, and called from Python without allocation: for callback peers."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from suite.task import Array


def dense(name: str, arguments: Sequence[ca.SX], results: Sequence[ca.SX]) -> Any:
    """A CasADi function whose results are all dense."""
    return ca.Function(name, list(arguments), [ca.densify(result) for result in results])


class NodeFunctions:
    """Compiled versions of some functions; `seconds` adds up the time spent in them."""

    def __init__(self, folder: Path, functions: Sequence[Any]) -> None:
        generator = ca.CodeGenerator("nodes.c")
        for function in functions:
            generator.add(function)
        folder.mkdir(parents=True, exist_ok=True)
        generator.generate(f"{folder}/")
        library = folder / "nodes.so"
        command = ["cc", "-O3", "-march=native", "-shared", "-fPIC", str(folder / "nodes.c"), "-o", str(library)]
        subprocess.run(command, check=True, timeout=300.0)
        self.seconds = 0.0
        self._calls = {function.name(): _Call(function, library) for function in functions}

    def __call__(self, name: str, *arguments: Array) -> list[Array]:
        """Evaluate; the results are overwritten by the next call of the same function."""
        started = time.perf_counter()
        results = self._calls[name](*arguments)
        self.seconds += time.perf_counter() - started
        return results


class _Call:
    """One function, its arguments and results in fixed memory; the same arguments are not evaluated twice in a row."""

    def __init__(self, function: Any, library: Path) -> None:
        self._function = ca.external(function.name(), str(library))
        self._buffer: Any
        self._buffer, self._evaluate = self._function.buffer()
        self._arguments = [np.full(function.size_in(i)[0], np.nan) for i in range(function.n_in())]
        flat = [np.zeros(function.numel_out(i)) for i in range(function.n_out())]
        for i, array in enumerate(self._arguments):
            self._buffer.set_arg(i, array.data)
        for i, array in enumerate(flat):
            self._buffer.set_res(i, array.data)
        shapes = [function.size_out(i) for i in range(function.n_out())]
        self._results = [
            array if shape[1] == 1 else array.reshape(shape, order="F")
            for array, shape in zip(flat, shapes, strict=True)
        ]
        self._last = b""

    def __call__(self, *arguments: Array) -> list[Array]:
        key = b"".join(argument.tobytes() for argument in arguments)
        if key != self._last:
            for own, given in zip(self._arguments, arguments, strict=True):
                own[:] = given
            self._evaluate()
            self._last = key
        return self._results
