"""What users give for an expression, as a column of CasADi SX."""

from __future__ import annotations

from typing import Any

import casadi as ca

from doorman.exceptions import SolverError


def column(name: str, expression: Any) -> Any:
    """A dense column."""
    try:
        entries = ca.vertcat(*expression) if isinstance(expression, (list, tuple)) else ca.SX(expression)
    except (NotImplementedError, TypeError) as error:
        raise SolverError(
            "not an expression", field=name, given=type(expression).__name__, allowed="CasADi SX, or numbers"
        ) from error
    return ca.densify(ca.vec(ca.SX(entries)))
