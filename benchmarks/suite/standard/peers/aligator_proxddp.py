"""aligator's ProxDDP, built for this processor, on generated C: no Python between its iterations. Its calls are timed in C++."""

from __future__ import annotations

import ctypes
import subprocess
import sys
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from build_native import ALIGATOR, packages

from suite.standard.peers.interface import StandardPeer
from suite.standard.task import Array, Case, StandardTask
from suite.task import Answer

BRIDGE = Path(__file__).parents[1] / "aligator_bridge.cpp"


class AligatorProxDdp(StandardPeer):
    """Gauss-Newton Hessian, tolerance 1e-6, linear rollout; replans are one iteration with shifted multipliers."""

    penalty, replan_penalty = 1e-4, 1e-6
    """Of the augmented Lagrangian at the start of a cold solve, and of a replan."""

    def __init__(self, task: StandardTask) -> None:
        super().__init__(task)
        counts, text = _functions(task)
        self._library = _compiled(task.name, text)
        low, high = (np.concatenate([task.state_bounds[side], task.input_bounds[side]]) for side in (0, 1))
        self._library.create.restype, self._library.solve.restype = ctypes.c_void_p, ctypes.c_double
        sizes = [ctypes.c_int(size) for size in (task.horizon, task.nx, task.nu, task.nq)]
        numbers = [ctypes.c_double(number) for number in (1e-6, self.penalty, self.replan_penalty)]
        rows = (ctypes.c_int * 3)(*counts)
        self._solver = ctypes.c_void_p(
            self._library.create(*sizes, rows, _at(low), _at(high), *numbers, ctypes.c_int(500))
        )
        self._seconds, self._warm = 0.0, False
        self._iterations, self._converged = ctypes.c_int(), ctypes.c_int()

    def prepare_cold(self, case: Case) -> None:
        """The case's guess, multipliers zero."""
        self._set(case, warm=False)

    def prepare_replan(self, case: Case) -> None:
        """Shifted states, inputs and multipliers."""
        self._set(self.follow(case), warm=True)

    def solve(self) -> None:
        """One call of the solver."""
        self._seconds = self._library.solve(
            self._solver, *map(_at, (self._start, self._parameters, self._states, self._inputs)),
            ctypes.c_int(self._warm), ctypes.byref(self._iterations), ctypes.byref(self._converged),
        )  # fmt: skip

    def own_seconds(self) -> float | None:
        """Duration of `run`; unknown where it failed."""
        return None if self._seconds < 0.0 else self._seconds

    def answer(self) -> Answer:
        """Trajectory and ProxDDP's own verdict; one iteration is used as it is."""
        failed, converged = self._seconds < 0.0, bool(self._converged.value)
        claim = "failed" if failed else "converged" if converged else "iteration limit"
        usable = not failed and (self._warm or converged)
        return Answer(self._states.copy(), self._inputs.copy(), self._iterations.value, claim, usable, converged)

    def _set(self, case: Case, warm: bool) -> None:
        self._warm, self._start = warm, np.ascontiguousarray(case.start)
        self._parameters = np.ascontiguousarray(case.node_parameters)
        self._states, self._inputs = np.array(case.states, order="C"), np.array(case.inputs, order="C")


def _at(array: Array) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def _functions(task: StandardTask) -> tuple[list[int], ca.CodeGenerator]:
    """Counts of rows at the first node, between and at the last; and the C of what the bridge calls."""
    x, u, q = ca.SX.sym("x", task.nx), ca.SX.sym("u", task.nu), ca.SX.sym("q", task.nq)
    z = ca.vertcat(x, u)
    at_inputs, at_states = task.function("rows")(x, u, q), task.function("state_rows")(x, q)
    rows = {
        "first_rows": (at_inputs, z), "rows": (ca.vertcat(at_inputs, at_states), z),
        "last_rows": (ca.vertcat(at_states, task.function("end_rows")(x, q)), x),
    }  # fmt: skip
    columns = {**rows, "next": (task.function("step")(x, u, q), z)}
    squares = {"stage": (task.function("stage_residual")(x, u, q), z), "end": (task.function("end_residual")(x, q), x)}
    generator = ca.CodeGenerator("functions.c")
    for name, (column, by) in columns.items():
        _add(generator, name, [x, u, q], column)
        _add(generator, f"{name}_slopes", [x, u, q], ca.jacobian(column, by))
    for name, (residual, by) in squares.items():
        slopes = ca.jacobian(residual, by)
        _add(generator, name, [x, u, q], 0.5 * ca.sumsqr(residual))
        _add(generator, f"{name}_gradient", [x, u, q], slopes.T @ residual)
        _add(generator, f"{name}_hessian", [x, u, q], slopes.T @ slopes)
    return [int(column.numel()) for column, _ in rows.values()], generator


def _add(generator: Any, name: str, arguments: list[Any], result: Any) -> None:
    generator.add(ca.Function(name, arguments, [ca.densify(result)]))


def _compiled(name: str, generator: Any) -> ctypes.CDLL:
    """The bridge with the functions of a problem."""
    folder = Path("aligator", "".join(letter if letter.isalnum() else "_" for letter in name)).absolute()
    folder.mkdir(parents=True, exist_ok=True)
    generator.generate(f"{folder}/")
    libraries = packages(Path(sys.executable))
    fast, library = ["-O3", "-march=native", "-fPIC"], folder / "solver.so"
    bridge = folder.parent / "bridge.o"
    if not bridge.is_file() or bridge.stat().st_mtime < BRIDGE.stat().st_mtime:
        headers = [f"-I{ALIGATOR.folder}/include", *(f"-I{libraries}/include{more}" for more in ("", "/eigen3"))]
        flags = ["-std=c++17", "-DNDEBUG", "-DALIGATOR_ENABLE_TEMPLATE_INSTANTIATION", *fast, *headers]
        _run(["c++", *flags, "-c", str(BRIDGE), "-o", str(bridge)])
    _run(["cc", *fast, "-c", str(folder / "functions.c"), "-o", str(folder / "functions.o")])
    places = [f"-L{path}/lib" for path in (ALIGATOR.folder, libraries)]
    found = ["-Wl,--no-as-needed", *(f"-Wl,-rpath,{path}/lib" for path in (ALIGATOR.folder, libraries))]
    objects = [str(bridge), str(folder / "functions.o")]
    _run(["c++", "-shared", *objects, *places, *found, "-lfmt", "-lmimalloc", "-laligator", "-o", str(library)])
    return ctypes.CDLL(str(library))


def _run(command: list[str]) -> None:
    subprocess.run(command, check=True, timeout=900.0)
