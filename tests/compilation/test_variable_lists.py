"""Variables of statements: those that numba's own definition lists, in its order."""

from __future__ import annotations

from typing import Any

from numba.core import ir
from numba.core.compiler import run_frontend

from doorman.compilation import kernel


@kernel
def installs() -> float:
    """Brings what lists variables."""
    return 0.0


def statements(values: Any, table: Any, given: float, *rest: float, deep: bool = True) -> Any:
    """All kinds of statements that kernels are made of."""
    total, pair = 0.0, (given, len(values))
    for index in range(values.shape[0]):
        if values[index] > given and deep:
            values[index] += max(given, pair[0], *rest)
        elif not deep:
            table[index, 0], table[index, 1:3] = pair[1], [given, total]
        total = total + values[index] ** 2 - pair[0]
    values[0] = 1.0
    del pair
    assert total > 0.0, "positive"
    return {"total": total, "both": (total, values)}


def plain(part: Any) -> list[ir.Var]:
    """Variables by numba's own definition."""
    if isinstance(part, ir.Var):
        return [part]
    if isinstance(part, ir.Inst):
        return plain(part._kws if isinstance(part, ir.Expr) else part.__dict__)
    parts = part.values() if isinstance(part, dict) else part if isinstance(part, list | tuple) else ()
    return [variable for each in parts for variable in plain(each)]


def test_variables_are_those_that_numba_lists() -> None:
    assert installs() == 0.0
    body = [statement for block in run_frontend(statements).blocks.values() for statement in block.body]
    assert {type(statement).__name__ for statement in body} > {"Assign", "Branch", "Jump", "Return", "SetItem"}
    assert sum(len(statement.list_vars()) for statement in body) > 100
    for statement in body:
        assert list(map(id, statement.list_vars())) == list(map(id, plain(statement))), statement
