"""The functions that make an optimal control problem, and how a model supplies them to compiled solvers.

A model is a NamedTuple of numbers and arrays; its type decides which kernels are called. numba resolves the names below at
compile time by that type. Solvers take a table of these functions instead, compiled once for the type of model
(`doorman.ocp.kernels.compiled_model`): they call by the same names, at addresses. Only `step` is obligatory: constraints and
costs that a model does not have count as absent, and a missing derivative is taken by central differences
(`doorman.ocp.kernels.defaults`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, TypeVar

from numba.core import types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import overload

from doorman.compilation import belongs_to
from doorman.exceptions import SolverError
from doorman.numba_types.function_tables import TABLE, FunctionTableType, call, with_number
from doorman.numba_types.handles import Handle, HandleType

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

_implementations: dict[tuple[str, type], Callable[..., Any]] = {}
"""Kernels by function and type of model."""
_defaults: dict[str, Callable[..., Any]] = {}


class ModelFunction:
    """A function of a model and arrays: the kernel of the model's type, or the default.

    Args:
        name: Its name in this module.
        arguments: numba's types after the model; of arrays, the numbers of their dimensions.
        returns: numba's type of the result.
    """

    places: ClassVar[dict[str, ModelFunction]] = {}
    """All of them, in the order in which tables have them."""

    def __init__(self, name: str, *arguments: Any, returns: Any = types.void) -> None:
        self.__name__, self.returns = name, returns
        self.arguments = tuple(types.Array(types.float64, n, "C") if isinstance(n, int) else n for n in arguments)
        self.place = len(self.places)
        self.places[name] = self
        _teach(self)

    def __call__(self, model: Any, *arguments: Any) -> Any:
        """Run it from Python."""
        content = _content_of(model)
        kernel = self.kernel_of(type(content))
        if not isinstance(content, tuple):  # Python's functions, on which compiled code cannot work
            kernel = getattr(kernel, "py_func", kernel)
        return kernel(model, *arguments)

    def __reduce__(self) -> str:
        return self.__name__

    def kernel_of(self, model: type) -> Callable[..., Any]:
        """Kernel of a type of model, or the default."""
        kernel = _implementations.get((self.__name__, model)) or _defaults.get(self.__name__)
        if kernel is None:
            known = sorted(name for name, owner in _implementations if owner is model)
            raise SolverError(
                f"no kernel for '{self.__name__}'", given=model.__name__, allowed=f"it has {', '.join(known) or 'none'}"
            )
        return kernel

    def of_table(self, given: Any) -> Any:
        """Signature of a table's function, if these are its arguments."""
        for one, other in zip(given, self.arguments, strict=True):
            is_array = isinstance(other, types.Array)
            if is_array and not (isinstance(one, types.Array) and (one.ndim, one.layout) == (other.ndim, "C")):
                raise TypingError(f"{self.__name__} of a table takes {self.arguments}, not {given}")
        return signature(self.returns, TABLE, *self.arguments)  # type: ignore[no-untyped-call]


def implement(function: Any, model: type) -> Callable[[Kernel], Kernel]:
    """Register a kernel as one of these functions for one type of model."""

    def register(kernel: Kernel) -> Kernel:
        _implementations[function.__name__, model] = kernel
        belongs_to(model, kernel)
        return kernel

    return register


def default(function: ModelFunction) -> Callable[[Kernel], Kernel]:
    """Register a kernel as one of these functions for every model that has none of its own."""

    def register(kernel: Kernel) -> Kernel:
        _defaults[function.__name__] = kernel
        return kernel

    return register


def is_implemented(function: ModelFunction, model: type) -> bool:
    """Whether a type of model has a kernel of its own for a function."""
    return (function.__name__, model) in _implementations


def has_own_cost(model: type) -> bool:
    """Whether a type of model has a cost beside the quadratic one."""
    return is_implemented(stage_cost, model) or is_implemented(end_cost, model)


def _content_of(model: Any) -> Any:
    """The model itself, also where a handle holds it."""
    return model.content if isinstance(model, Handle) else model


def _instance_class(given: Any) -> Any:
    """Type of a model by numba's type of it or of its handle; None for other arguments."""
    return getattr(given.content if isinstance(given, HandleType) else given, "instance_class", None)


def _teach(function: ModelFunction) -> None:
    """Let kernels call a function: the kernel of their model's type, or that of a table."""

    class Template(AbstractTemplate):
        key = function

        def generic(self, args: Any, kws: Any) -> Any:
            if args[0] is TABLE:
                return function.of_table(args[1:])
            model = _instance_class(args[0])
            if model is None:
                return None
            return self.context.resolve_value_type(function.kernel_of(model)).get_call_type(self.context, args, kws)

        def get_impl_key(self, sig: Any) -> Any:
            if sig.args[0] is TABLE:
                return function
            kernel: Any = function.kernel_of(_instance_class(sig.args[0]))
            return kernel.get_overload(sig)

    @lower_builtin(function, FunctionTableType, types.VarArg(types.Any))  # type: ignore[no-untyped-call, untyped-decorator]
    def build(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return call(context, builder, function.place, sig, args)

    infer_global(function, types.Function(Template))  # type: ignore[no-untyped-call]


def at_node(model: Any, k: int) -> Any:
    """The model as node k sees it: itself, or what a model whose numbers change along the horizon has for that node."""
    content = _content_of(model)
    choose = _implementations.get(("at_node", type(content)))
    return model if choose is None else choose(content, k)


@overload(at_node, strict=False)
def _compiled_at_node(model: Any, k: Any) -> Any:
    """Compiled into its callers: a handle goes through unchanged, and a table's functions choose themselves."""
    if model is TABLE:
        return lambda model, k: with_number(model, k)
    choose = _implementations.get(("at_node", _instance_class(model)))
    return (lambda model, k: model) if choose is None else choose


step = ModelFunction("step", 1, 1, 1)
"""Discrete dynamics, x⁺ = f(x, u): model, x, u, out."""
linearize_step = ModelFunction("linearize_step", 1, 1, 2)
"""Jacobian [A | B] of `step`: model, x, u, jacobian."""
constrain = ModelFunction("constrain", 1, 1)
"""Constraints h(x) ≤ 0 of every state after the first: model, x, h."""
linearize_constraints = ModelFunction("linearize_constraints", 1, 1, 2)
"""Constraints h(x) ≤ 0 of a state, and their Jacobian: model, x, h, jacobian."""
constrain_input = ModelFunction("constrain_input", 1, 1, 1)
"""Mixed constraints g(x, u) ≤ 0 of every node but the last: model, x, u, g."""
linearize_input_constraints = ModelFunction("linearize_input_constraints", 1, 1, 1, 2)
"""Mixed constraints g(x, u) ≤ 0, and their Jacobian: model, x, u, g, jacobian."""
constrain_end = ModelFunction("constrain_end", 1, 1)
"""Constraints h_N(x_N) ≤ 0 of the last state only: model, x, h."""
linearize_end_constraints = ModelFunction("linearize_end_constraints", 1, 1, 2)
"""Constraints h_N(x_N) ≤ 0 of the last state, and their Jacobian: model, x, h, jacobian."""
stage_cost = ModelFunction("stage_cost", 1, 1, returns=types.float64)
"""Cost of a node on top of the quadratic one, already times Δt: model, x, u."""
expand_stage_cost = ModelFunction("expand_stage_cost", 1, 1, 1, 2)
"""Gradient and positive semidefinite Hessian of `stage_cost`, or the Gauss-Newton Hessian: model, x, u, gradient, hessian."""
end_cost = ModelFunction("end_cost", 1, returns=types.float64)
"""Cost of the last state on top of the quadratic one: model, x."""
expand_end_cost = ModelFunction("expand_end_cost", 1, 1, 2)
"""Gradient and positive semidefinite Hessian of `end_cost`, or the Gauss-Newton Hessian: model, x, gradient, hessian."""
linearize_horizon = ModelFunction("linearize_horizon", 2, 2, 3, 2, 3)
"""All nodes at once: model, states, inputs, jacobians, rows, row_jacobians. A model may take many nodes side by side."""
constrain_horizon = ModelFunction("constrain_horizon", 2, 2)
"""Constraints h(x) of all nodes 1 … N at once: model, states, rows."""
curve_horizon = ModelFunction("curve_horizon", 2, 2, 2, 2, types.int64, types.int64, types.int64, 2, 3)
"""Second derivatives of the Lagrangian ℓ + pᵀf + yᵀ(h, h_N, g) at all nodes, without the quadratic cost: model, states, inputs,
costates p, prices y, numbers of rows of h, h_N and g, gradients of ℓ, hessians."""
slope = ModelFunction("slope", 1, 1, 1, 1, 1, 1, 1)
"""Gradient of pᵀf + yᵀ(h, h_N, g) of a node: model, x, u, p, prices of h, of h_N and of g, out. What does not count is empty."""
