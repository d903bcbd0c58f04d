"""How a model supplies functions to compiled solvers: the kernels of its type, by the functions' names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from numba.core import types
from numba.core.errors import TypingError
from numba.core.imputils import lower_builtin
from numba.core.typing.templates import AbstractTemplate, infer_global, signature

from doorman.compilation import belongs_to
from doorman.exceptions import SolverError
from doorman.numba_types.function_tables import TABLE, FunctionTableType, call
from doorman.numba_types.handles import Handle, HandleType

Kernel = TypeVar("Kernel", bound=Callable[..., Any])

implementations: dict[tuple[str, type], Callable[..., Any]] = {}
"""Kernels by function and type of model."""
_defaults: dict[str, Callable[..., Any]] = {}

ARGUMENTS: dict[str, tuple[Any, ...]] = {}
"""numba's types of each function's arguments after the model, as tables of functions have them."""


def implement(function: Callable[..., Any], model: type) -> Callable[[Kernel], Kernel]:
    """Register a kernel as one of the functions of `functions` for one type of model."""

    def register(kernel: Kernel) -> Kernel:
        implementations[function.__name__, model] = kernel
        belongs_to(model, kernel)
        return kernel

    return register


def default(function: Callable[..., Any]) -> Callable[[Kernel], Kernel]:
    """Register a kernel as one of the functions of `functions` for every model that has none of its own."""

    def register(kernel: Kernel) -> Kernel:
        _defaults[function.__name__] = kernel
        return kernel

    return register


def is_implemented(function: Callable[..., Any], model: type) -> bool:
    """Whether a type of model has a kernel of its own for a function of `functions`."""
    return (function.__name__, model) in implementations


def kernel_of(name: str, model: type) -> Callable[..., Any]:
    """Kernel of a type of model for a function, or the default."""
    kernel = implementations.get((name, model)) or _defaults.get(name)
    if kernel is None:
        known = sorted(function for function, owner in implementations if owner is model)
        raise SolverError(
            f"no kernel for '{name}'", given=model.__name__, allowed=f"it has {', '.join(known) or 'none'}"
        )
    return kernel


def content_of(model: Any) -> Any:
    """The model itself, also where a handle holds it."""
    return model.content if isinstance(model, Handle) else model


def type_of(model: Any) -> type:
    """Type of a model."""
    return type(content_of(model))


def instance_class(given: Any) -> Any:
    """Type of a model by numba's type of it or of its handle; None for other arguments."""
    return getattr(given.content if isinstance(given, HandleType) else given, "instance_class", None)


def compiled(*shapes: Any, returns: Any = types.void) -> Callable[[Kernel], Kernel]:
    """Let kernels call a function of `functions`: the kernel of their model's type, or that of a table."""
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
                model = instance_class(args[0])
                if model is None:
                    return None
                return self.context.resolve_value_type(kernel_of(name, model)).get_call_type(self.context, args, kws)

            def get_impl_key(self, sig: Any) -> Any:
                if sig.args[0] is TABLE:
                    return function
                kernel: Any = kernel_of(name, instance_class(sig.args[0]))
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
