"""Types of operators in kernels: those that numba finds, and found once."""

from __future__ import annotations

import itertools
import operator
from typing import Any

import pytest
from numba.core import types
from numba.core.errors import TypingError
from numba.core.registry import cpu_target

from doorman.compilation import kernel, operator_types
from doorman.numba_types.lanes import Lanes

ROWS = types.Array(types.float64, 2, "C")
KINDS = (types.float64, types.int64, types.boolean, types.literal(2), Lanes(8), ROWS, types.Array(Lanes(8), 1, "C"))
INDICES = (types.int64, types.literal(1), types.UniTuple(types.int64, 2), types.Tuple((types.int64, types.literal(0))))
PAIR = types.UniTuple(types.float64, 2)
BINARY = (operator.add, operator.sub, operator.mul, operator.truediv, operator.pow, operator.lt, operator.eq)


@kernel
def add(left: Any, right: Any) -> Any:
    """Makes numba know its operators."""
    return left + right


def found(operation: Any, *kinds: Any, anew: bool) -> Any:
    """What numba, or its first search, says of an operator; None where the operands do not fit."""
    context = cpu_target.typing_context
    function = context.resolve_value_type(operation)
    try:
        search = operator_types._search if anew else type(function).get_call_type
        signature = search(function, context, kinds, {})
    except TypingError:
        return None
    return signature, function.get_impl_key(signature)


@pytest.mark.parametrize("operation", BINARY)
def test_types_of_operators_are_those_of_a_search(operation: Any) -> None:
    add(1.0, 2.0)
    for left, right in itertools.product(KINDS, KINDS):
        expected = found(operation, left, right, anew=True)
        for _ in range(2):
            assert found(operation, left, right, anew=False) == expected


@pytest.mark.parametrize("index", INDICES)
def test_types_of_elements_are_those_of_a_search(index: Any) -> None:
    add(1.0, 2.0)
    for operation, operands in ((operator.getitem, (ROWS, index)), (operator.setitem, (ROWS, index, types.float64))):
        expected = found(operation, *operands, anew=True)
        assert expected is not None or operation is operator.setitem
        assert [found(operation, *operands, anew=False) for _ in range(2)] == [expected, expected]


@pytest.mark.parametrize(("kinds", "searches"), [((types.float64, Lanes(8)), 1), ((PAIR, PAIR), 2)])
def test_operators_are_searched_once_but_for_those_that_are_functions(
    kinds: tuple[Any, Any], searches: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    add(1.0, 2.0)
    searched, search = [], operator_types._search
    monkeypatch.setattr(operator_types, "_found", {})
    monkeypatch.setattr(operator_types, "_search", lambda *given: (searched.append(given), search(*given))[1])
    for _ in range(2):
        assert found(operator.add, *kinds, anew=False) is not None
    assert len(searched) == searches
