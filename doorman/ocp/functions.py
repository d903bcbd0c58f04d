"""The four functions that make an optimal control problem, and how a model supplies them to compiled solvers.

A model is a NamedTuple of numbers and arrays; its type decides which kernels the solvers call. numba resolves the four
names below at compile time by that type, so solver kernels are written once, stay inlinable, and are cached on disk
(functions passed as arguments would not be).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numba.extending import overload
from numpy.typing import NDArray

from doorman.compilation import belongs_to

Array = NDArray[np.float64]
Kernel = TypeVar("Kernel", bound=Callable[..., None])

_implementations: dict[tuple[str, type], Callable[..., None]] = {}


def implement(function: Callable[..., None], model: type) -> Callable[[Kernel], Kernel]:
    """Register a kernel as one of the four functions for one type of model.

    Args:
        function: `step`, `linearize_step`, `constrain` or `linearize_constraints`.
        model: The NamedTuple type of the model.

    Returns:
        A decorator for the kernel, which must have the signature of `function`.
    """

    def register(kernel: Kernel) -> Kernel:
        _implementations[function.__name__, model] = kernel
        belongs_to(model, kernel)
        return kernel

    return register


def step(model: Any, x: Array, u: Array, out: Array) -> None:
    """Discrete dynamics, x⁺ = f(x, u), into `out` (nx,)."""
    _implementations["step", type(model)](model, x, u, out)


def linearize_step(model: Any, x: Array, u: Array, out: Array) -> None:
    """Jacobian [A | B] of `step` into `out` (nx, nx + nu)."""
    _implementations["linearize_step", type(model)](model, x, u, out)


def constrain(model: Any, x: Array, h: Array) -> None:
    """Constraints h(x) ≤ 0 of every state after the first, into `h` (nh,)."""
    _implementations["constrain", type(model)](model, x, h)


def linearize_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    """Constraints into `h` (nh,) and their Jacobian into `jacobian` (nh, nx)."""
    _implementations["linearize_constraints", type(model)](model, x, h, jacobian)


def _kernel_of(name: str, model: Any) -> Callable[..., None] | None:
    return _implementations.get((name, getattr(model, "instance_class", type(None))))


@overload(step, strict=False)
def _compiled_step(model: Any, x: Any, u: Any, out: Any) -> Any:
    kernel = _kernel_of("step", model)
    return None if kernel is None else lambda model, x, u, out: kernel(model, x, u, out)


@overload(linearize_step, strict=False)
def _compiled_linearize_step(model: Any, x: Any, u: Any, out: Any) -> Any:
    kernel = _kernel_of("linearize_step", model)
    return None if kernel is None else lambda model, x, u, out: kernel(model, x, u, out)


@overload(constrain, strict=False)
def _compiled_constrain(model: Any, x: Any, h: Any) -> Any:
    kernel = _kernel_of("constrain", model)
    return None if kernel is None else lambda model, x, h: kernel(model, x, h)


@overload(linearize_constraints, strict=False)
def _compiled_linearize_constraints(model: Any, x: Any, h: Any, jacobian: Any) -> Any:
    kernel = _kernel_of("linearize_constraints", model)
    return None if kernel is None else lambda model, x, h, jacobian: kernel(model, x, h, jacobian)
