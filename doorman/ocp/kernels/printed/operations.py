"""CasADi's operations in the words of kernels: a table, and the error for what is not in it."""

from __future__ import annotations

import casadi as ca

from doorman.exceptions import SolverError

_WORDS = {
    "ADD": "{0} + {1}", "SUB": "{0} - {1}", "MUL": "{0} * {1}", "DIV": "{0} / {1}", "NEG": "-{0}", "SQ": "{0} * {0}",
    "TWICE": "2.0 * {0}", "INV": "1.0 / {0}", "ASSIGN": "{0}",
    "SQRT": "square_root({0})", "TANH": "tanh({0})", "FMAX": "larger({0}, {1})", "FMIN": "smaller({0}, {1})",
    "FABS": "absolute({0})", "SIGN": "sign({0})", "FLOOR": "rounded_down({0})", "CEIL": "rounded_up({0})",
    "COPYSIGN": "with_sign_of({0}, {1})", "FMOD": "remainder({0}, {1})", "IF_ELSE_ZERO": "kept_if({0}, {1})",
    "LT": "less({0}, {1})", "LE": "less_or_equal({0}, {1})", "EQ": "equal({0}, {1})", "NE": "different({0}, {1})",
    "NOT": "negated({0})", "AND": "both({0}, {1})", "OR": "either({0}, {1})",
    "EXP": "exponential({0})", "EXPM1": "exponential_less_one({0})", "LOG": "logarithm({0})",
    "LOG1P": "logarithm_of_more_than_one({0})", "POW": "power({0}, {1})", "CONSTPOW": "power({0}, {1})",
    "HYPOT": "hypotenuse({0}, {1})", "ERF": "error_function({0})", "TAN": "tangent({0})", "ASIN": "arcsine({0})",
    "ACOS": "arccosine({0})", "ATAN": "arctangent({0})", "ATAN2": "angle_of({0}, {1})", "SINH": "hyperbolic_sine({0})",
    "COSH": "hyperbolic_cosine({0})", "ASINH": "area_sine({0})", "ACOSH": "area_cosine({0})",
    "ATANH": "area_tangent({0})",
}  # fmt: skip

_NAMES = {getattr(ca, name): name for name in dir(ca) if name.startswith("OP_")}

WORDS = {getattr(ca, f"OP_{name}"): words for name, words in _WORDS.items()}
"""Template by CasADi's number of the operation."""


def words_for(operation: int, where: str) -> str:
    """Template of an operation."""
    if operation not in WORDS:
        raise SolverError(
            "this operation cannot be compiled", field=where, given=_NAMES.get(operation, str(operation)),
            allowed=", ".join(sorted({*_WORDS, "SIN", "COS"})),
        )  # fmt: skip
    return WORDS[operation]
