"""Types of operators in kernels, searched once for every set of operands' types.

numba has a dozen definitions of each operator. It tries them in turn wherever the operator stands, once to infer types and once
to lower, and words an error for each that does not fit. In formulas of thousands of operations this took half the time.
"""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

from numba.core import types
from numba.core.types.functions import BaseFunction

_OPERATORS = "_operator"
"""Module of the functions by which numba knows operators."""

_ELSEWHERE = (
    types.BaseTuple, types.Callable, types.NoneType, types.Omitted, types.Optional, types.Poison, types.Undefined,
    types.UnicodeType,
)  # fmt: skip
"""Operands whose operators are no instructions but compiled functions, which depend on more than types."""

_found: WeakKeyDictionary[Any, dict[Any, Any]] = WeakKeyDictionary()
"""Signatures and numba's keys of their implementations, by function and operands' types."""

_search: Any = BaseFunction.get_call_type


def install() -> None:
    """Have numba look up what it has found, from now on and whatever it compiles."""
    function_types: Any = BaseFunction
    function_types.get_call_type = _get_call_type


def _get_call_type(function: Any, context: Any, args: Any, kws: Any) -> Any:
    """Signature of a call: that of the first search, where the function is an operator of numbers, lanes or arrays."""
    if kws or getattr(function.typing_key, "__module__", None) != _OPERATORS or any(map(_is_elsewhere, args)):
        return _search(function, context, args, kws)
    found = _found.setdefault(function, {})
    key = context, tuple(args)
    if key not in found:
        signature = _search(function, context, args, kws)
        found[key] = signature, function.get_impl_key(signature)
    signature, implementation = found[key]
    function._impl_keys[signature.args] = implementation
    return signature


def _is_elsewhere(kind: Any) -> bool:
    parts = getattr(kind, "types", ())
    if isinstance(kind, types.BaseTuple) and parts:
        return not all(isinstance(each, types.Integer | types.SliceType) for each in parts)  # an array's index
    return isinstance(kind, _ELSEWHERE)
