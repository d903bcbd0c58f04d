"""The functions that make an optimal control problem, and how a model supplies them to compiled solvers.

A model is a NamedTuple of numbers and arrays; its type decides which kernels are called. numba resolves the names below at
compile time by that type. Solvers take a table of these functions instead, compiled once for the type of model
(`doorman.ocp.kernels.compiled_model`): they call by the same names, at addresses. Only `step` is obligatory: constraints and
costs that a model does not have count as absent, and a missing derivative is taken by central differences
(`doorman.ocp.kernels.defaults`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numba.core import types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import overload
from numpy.typing import NDArray

from doorman.compilation import belongs_to
from doorman.exceptions import SolverError
from doorman.numba_types.function_tables import TABLE, FunctionTableType, call, with_number
from doorman.numba_types.handles import Handle, HandleType

Array = NDArray[np.float64]
Kernel = TypeVar("Kernel", bound=Callable[..., Any])

_implementations: dict[tuple[str, type], Callable[..., Any]] = {}
_defaults: dict[str, Callable[..., Any]] = {}

ARGUMENTS: dict[str, tuple[Any, ...]] = {}
"""numba's types of each function's arguments after the model, as tables of functions have them."""

_COUNTS = types.UniTuple(types.int64, 3)  # type: ignore[no-untyped-call]


def implement(function: Callable[..., Any], model: type) -> Callable[[Kernel], Kernel]:
    """Register a kernel as one of the functions below for one type of model.

    Args:
        function: A function of this module.
        model: The NamedTuple type of the model.

    Returns:
        A decorator for the kernel, which must have the signature of `function`.
    """

    def register(kernel: Kernel) -> Kernel:
        _implementations[function.__name__, model] = kernel
        belongs_to(model, kernel)
        return kernel

    return register


def default(function: Callable[..., Any]) -> Callable[[Kernel], Kernel]:
    """Register a kernel as one of the functions below for every model that has none of its own.

    Args:
        function: One of this module.

    Returns:
        A decorator of the kernel, which it returns.
    """

    def register(kernel: Kernel) -> Kernel:
        _defaults[function.__name__] = kernel
        return kernel

    return register


def is_implemented(function: Callable[..., Any], model: type) -> bool:
    """Whether a type of model has a kernel of its own for a function of this module.

    Args:
        function: One of this module.
        model: Type of the model.
    """
    return (function.__name__, model) in _implementations


def _kernel_of(name: str, model: type) -> Callable[..., Any]:
    kernel = _implementations.get((name, model)) or _defaults.get(name)
    if kernel is None:
        known = sorted(function for function, owner in _implementations if owner is model)
        raise SolverError(
            f"no kernel for '{name}'", given=model.__name__, allowed=f"it has {', '.join(known) or 'none'}"
        )
    return kernel


def _content_of(model: Any) -> Any:
    return model.content if isinstance(model, Handle) else model


def _type_of(model: Any) -> type:
    return type(_content_of(model))


def _instance_class(given: Any) -> Any:
    """Type of a model by numba's type of it or of its handle; None for other arguments."""
    return getattr(given.content if isinstance(given, HandleType) else given, "instance_class", None)


def _compiled(*shapes: Any, returns: Any = types.void) -> Callable[[Kernel], Kernel]:
    """Let kernels call a function of this module: the kernel of their model's type, or that of a table.

    Args:
        shapes: Number of dimensions of each array after the model, or numba's type of what is no array.
        returns: numba's type of the result.
    """
    expected = tuple(types.Array(types.float64, each, "C") if isinstance(each, int) else each for each in shapes)

    def teach(function: Kernel) -> Kernel:
        name = function.__name__
        place = len(ARGUMENTS)
        ARGUMENTS[name] = expected

        class Template(AbstractTemplate):
            key = function

            def generic(self, args: Any, kws: Any) -> Any:
                if args[0] is TABLE:
                    return _checked(name, args[1:], expected, returns)
                model = _instance_class(args[0])
                if model is None:
                    return None
                return self.context.resolve_value_type(_kernel_of(name, model)).get_call_type(self.context, args, kws)

            def get_impl_key(self, sig: Any) -> Any:
                if sig.args[0] is TABLE:
                    return function
                kernel: Any = _kernel_of(name, _instance_class(sig.args[0]))
                return kernel.get_overload(sig)

        @lower_builtin(function, FunctionTableType, types.VarArg(types.Any))  # type: ignore[no-untyped-call, untyped-decorator]
        def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
            return call(context, builder, place, sig, args)

        infer_global(function, types.Function(Template))  # type: ignore[no-untyped-call]
        return function

    return teach


def _checked(name: str, given: Any, expected: Any, returns: Any) -> Any:
    """Signature of a table's function, if these are its arguments."""
    for one, other in zip(given, expected, strict=True):
        is_array = isinstance(other, types.Array)
        if is_array and not (isinstance(one, types.Array) and one.ndim == other.ndim and one.layout == other.layout):
            raise TypingError(f"{name} of a table takes {expected}, not {given}")
    return signature(returns, TABLE, *expected)  # type: ignore[no-untyped-call]


def at_node(model: Any, k: int) -> Any:
    """The model as node k sees it: itself, or what a model whose numbers change along the horizon has for that node.

    Args:
        model: The model.
        k: Node, 0 … N.
    """
    choose = _implementations.get(("at_node", _type_of(model)))
    return model if choose is None else choose(_content_of(model), k)


@overload(at_node, strict=False)
def _compiled_at_node(model: Any, k: Any) -> Any:
    """Compiled into its callers: a handle goes through unchanged, and a table's functions choose themselves."""
    if model is TABLE:
        return lambda model, k: with_number(model, k)
    choose = _implementations.get(("at_node", _instance_class(model)))
    return (lambda model, k: model) if choose is None else choose


@_compiled(1, 1, 1)
def step(model: Any, x: Array, u: Array, out: Array) -> None:
    """Discrete dynamics, x⁺ = f(x, u).

    Args:
        model: The model.
        x: State, shape (nx,).
        u: Input, shape (nu,).
        out: x⁺, shape (nx,), filled.
    """
    _kernel_of("step", _type_of(model))(model, x, u, out)


@_compiled(1, 1, 2)
def linearize_step(model: Any, x: Array, u: Array, jacobian: Array) -> None:
    """Jacobian [A | B] of `step`.

    Args:
        model: The model.
        x: State, shape (nx,).
        u: Input, shape (nu,).
        jacobian: [A | B], shape (nx, nx + nu), filled.
    """
    _kernel_of("linearize_step", _type_of(model))(model, x, u, jacobian)


@_compiled(1, 1)
def constrain(model: Any, x: Array, h: Array) -> None:
    """Constraints h(x) ≤ 0 of every state after the first.

    Args:
        model: The model.
        x: State, shape (nx,).
        h: Shape (nh,), filled.
    """
    _kernel_of("constrain", _type_of(model))(model, x, h)


@_compiled(1, 1, 2)
def linearize_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    """Constraints h(x) ≤ 0 of a state, and their Jacobian.

    Args:
        model: The model.
        x: State, shape (nx,).
        h: Shape (nh,), filled.
        jacobian: ∂h/∂x, shape (nh, nx), filled.
    """
    _kernel_of("linearize_constraints", _type_of(model))(model, x, h, jacobian)


@_compiled(1, 1, 1)
def constrain_input(model: Any, x: Array, u: Array, g: Array) -> None:
    """Mixed constraints g(x, u) ≤ 0 of every node but the last.

    Args:
        model: The model.
        x: State, shape (nx,).
        u: Input, shape (nu,).
        g: Shape (ng,), filled.
    """
    _kernel_of("constrain_input", _type_of(model))(model, x, u, g)


@_compiled(1, 1, 1, 2)
def linearize_input_constraints(model: Any, x: Array, u: Array, g: Array, jacobian: Array) -> None:
    """Mixed constraints g(x, u) ≤ 0, and their Jacobian.

    Args:
        model: The model.
        x: State, shape (nx,).
        u: Input, shape (nu,).
        g: Shape (ng,), filled.
        jacobian: [g_x | g_u], shape (ng, nx + nu), filled.
    """
    _kernel_of("linearize_input_constraints", _type_of(model))(model, x, u, g, jacobian)


@_compiled(1, 1)
def constrain_end(model: Any, x: Array, h: Array) -> None:
    """Constraints h_N(x_N) ≤ 0 of the last state only.

    Args:
        model: The model.
        x: x_N, shape (nx,).
        h: Shape (nt,), filled.
    """
    _kernel_of("constrain_end", _type_of(model))(model, x, h)


@_compiled(1, 1, 2)
def linearize_end_constraints(model: Any, x: Array, h: Array, jacobian: Array) -> None:
    """Constraints h_N(x_N) ≤ 0 of the last state, and their Jacobian.

    Args:
        model: The model.
        x: x_N, shape (nx,).
        h: Shape (nt,), filled.
        jacobian: ∂h_N/∂x, shape (nt, nx), filled.
    """
    _kernel_of("linearize_end_constraints", _type_of(model))(model, x, h, jacobian)


@_compiled(1, 1, returns=types.float64)
def stage_cost(model: Any, x: Array, u: Array) -> float:
    """Cost of a node on top of the quadratic one, already times Δt.

    Args:
        model: The model.
        x: State, shape (nx,).
        u: Input, shape (nu,).
    """
    return float(_kernel_of("stage_cost", _type_of(model))(model, x, u))


@_compiled(1, 1, 1, 2)
def expand_stage_cost(model: Any, x: Array, u: Array, gradient: Array, hessian: Array) -> None:
    """Gradient and positive semidefinite Hessian of `stage_cost`, or the Gauss-Newton Hessian.

    Args:
        model: The model.
        x: State, shape (nx,).
        u: Input, shape (nu,).
        gradient: By [x, u], shape (nx + nu,), filled.
        hessian: Shape (nx + nu, nx + nu), filled.
    """
    _kernel_of("expand_stage_cost", _type_of(model))(model, x, u, gradient, hessian)


@_compiled(1, returns=types.float64)
def end_cost(model: Any, x: Array) -> float:
    """Cost of the last state on top of the quadratic one.

    Args:
        model: The model.
        x: x_N, shape (nx,).
    """
    return float(_kernel_of("end_cost", _type_of(model))(model, x))


@_compiled(1, 1, 2)
def expand_end_cost(model: Any, x: Array, gradient: Array, hessian: Array) -> None:
    """Gradient and positive semidefinite Hessian of `end_cost`, or the Gauss-Newton Hessian.

    Args:
        model: The model.
        x: x_N, shape (nx,).
        gradient: By x, shape (nx,), filled.
        hessian: Shape (nx, nx), filled.
    """
    _kernel_of("expand_end_cost", _type_of(model))(model, x, gradient, hessian)


@_compiled(2, 2, 3, 2, 3)
def linearize_horizon(
    model: Any, states: Array, inputs: Array, jacobians: Array, rows: Array, row_jacobians: Array
) -> None:
    """All nodes at once; a model may have a kernel that takes many nodes side by side.

    Args:
        model: The model.
        states: X, (N + 1, nx).
        inputs: U, (N, nu).
        jacobians: [A | e | B | 0] with the defect e = f(x_k, u_k) − x_{k+1}, (N, nx, wide), written but for the zeros.
        rows: h at nodes 1 … N, (N, nh), written.
        row_jacobians: [h_x | 0], (N, nh, narrow), written but for the zeros.
    """
    _kernel_of("linearize_horizon", _type_of(model))(model, states, inputs, jacobians, rows, row_jacobians)


@_compiled(2, 2)
def constrain_horizon(model: Any, states: Array, rows: Array) -> None:
    """Constraints h(x) of all nodes 1 … N at once.

    Args:
        model: The model.
        states: X, shape (N + 1, nx).
        rows: Values of h, shape (N, nh), filled.
    """
    _kernel_of("constrain_horizon", _type_of(model))(model, states, rows)


@_compiled(2, 2, 2, 2, _COUNTS, 2, 3)
def curve_horizon(
    model: Any, states: Array, inputs: Array, costates: Array, prices: Array, counts: tuple[int, int, int],
    gradients: Array, hessians: Array,
) -> None:  # fmt: skip
    """Second derivatives of the Lagrangian ℓ + pᵀf + yᵀ(h, h_N, g) at all nodes, without the quadratic cost.

    Args:
        model: The model.
        states: X, (N + 1, nx).
        inputs: U, (N, nu).
        costates: p, (N, nx).
        prices: y at nodes 0 … N, of h, then of h_N and of g, (N + 1, at least so many); zero where a row does not exist.
        counts: Numbers of rows of h, h_N and g.
        gradients: Of `stage_cost` and `end_cost` alone, (N + 1, nx + nu), written.
        hessians: (N + 1, nx + nu, nx + nu), written.
    """
    _kernel_of("curve_horizon", _type_of(model))(model, states, inputs, costates, prices, counts, gradients, hessians)
