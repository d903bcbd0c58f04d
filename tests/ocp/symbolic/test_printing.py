"""Printed operations against CasADi's own evaluation, on numbers and on lanes."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from doorman.exceptions import SolverError
from doorman.ocp.kernels.printed.loading import load
from doorman.ocp.kernels.printed.operations import words_for
from doorman.ocp.kernels.printed.printing import printed
from doorman.ocp.kernels.runtime import LANES

a, b = ca.SX.sym("a"), ca.SX.sym("b")
EXPRESSIONS = ca.vertcat(
    a + b, a - b, a * b, a / b, -a, a**2, ca.sqrt(ca.fabs(a)), ca.sin(a), ca.cos(a), ca.sin(a) * ca.cos(b), ca.tan(a),
    ca.asin(a / 3), ca.acos(a / 3), ca.atan(a), ca.atan2(a, b), ca.sinh(a), ca.cosh(a), ca.tanh(a), ca.asinh(a),
    ca.acosh(a * a + 1), ca.atanh(a / 3), ca.exp(a), ca.log(ca.fabs(a) + 0.1), ca.expm1(a), ca.log1p(a * a), a**3,
    (a * a) ** b, a**-1.5, ca.fmax(a, b), ca.fmin(a, b), ca.sign(a), ca.floor(a), ca.ceil(a), ca.fmod(a, b),
    ca.copysign(a, b), ca.hypot(a, b), ca.erf(a), ca.if_else(a < b, a, 3 * b), ca.if_else(ca.logic_and(a > 0, b <= 0), a, b),
    ca.logic_or(a > 1, b > 1), ca.logic_not(a), a == b, a != b, 2 * a, 1 / a, ca.SX(1.5) + a, ca.SX(0.25),
)  # fmt: skip
COUNT = EXPRESSIONS.numel()


def module():
    """The expressions as a kernel of numbers and as one of lanes."""
    arguments = {"z": ca.vertcat(a, b)}
    plain = printed("all", arguments, [EXPRESSIONS], lambda n, i: f"{n}[{i}]", lambda k, i, v: f"out[{i}] = {v}")
    side_by_side = printed(
        "all", arguments, [EXPRESSIONS], lambda n, i: f"get({n}, {i}, WIDTH)",
        lambda k, i, v: f"put(out, {i}, zero(WIDTH) + {v})",
    )  # fmt: skip
    kernels = "".join(
        f"@straight\ndef {name}(z, out):\n    " + "\n    ".join(lines) + "\n\n\n"
        for name, lines in (("plain", plain), ("side_by_side", side_by_side))
    )
    imports = "from doorman.numba_types.straight import straight\nfrom doorman.ocp.kernels.runtime import WIDTH\n"
    return load("import numpy as np\n" + imports + "\n\n" + kernels)


def test_operations_are_those_of_casadi() -> None:
    kernels, random = module(), np.random.default_rng(1)
    function = ca.Function("truth", [ca.vertcat(a, b)], [EXPRESSIONS])
    with np.errstate(all="ignore"):
        points = [
            *random.uniform(-2.9, 2.9, (60, 2)),
            [1.0, 1.0],
            [0.0, -1.0],
            [-1.0, 0.5],
            [-0.0, 2.0],
            [0.0, 0.0],
            [2.5, 2.5],
        ]
    for first in range(0, len(points), LANES):
        block = np.array([points[min(first + i, len(points) - 1)] for i in range(LANES)]).T.copy()
        lanes = np.zeros((COUNT, LANES))
        kernels.side_by_side(block, lanes)
        for i in range(LANES):
            numbers, truth = np.zeros(COUNT), np.array(ca.densify(function(block[:, i]))).ravel()
            kernels.plain(block[:, i].copy(), numbers)
            assert np.allclose(numbers, truth, rtol=1e-13, atol=1e-15, equal_nan=True), np.flatnonzero(
                ~np.isclose(numbers, truth, rtol=1e-13, atol=1e-15, equal_nan=True)
            )
            assert np.allclose(lanes[:, i], truth, rtol=1e-13, atol=1e-15, equal_nan=True)


def test_nan_stays_nan() -> None:
    kernels = module()
    numbers, lanes = np.zeros(COUNT), np.zeros((COUNT, LANES))
    kernels.plain(np.array([np.nan, 1.0]), numbers)
    kernels.side_by_side(np.full((2, LANES), np.nan), lanes)
    sums = slice(0, 6)
    assert np.isnan(numbers[sums]).all() and np.isnan(lanes[sums]).all()


def test_every_operation_of_expressions_has_words_or_is_refused() -> None:
    with pytest.raises(SolverError, match="ERFINV"):
        words_for(ca.OP_ERFINV, "here")
    assert words_for(ca.OP_ADD, "here").format("a", "b") == "a + b"


def test_common_subexpressions_are_computed_once() -> None:
    twice = ca.vertcat(ca.exp(a * b) + 1, 2 * ca.exp(a * b))
    lines = printed("t", {"z": ca.vertcat(a, b)}, [twice], lambda n, i: f"{n}[{i}]", lambda k, i, v: f"o[{i}] = {v}")
    assert sum("exponential" in line for line in lines) == 1


def test_numbers_that_are_not_finite_are_printed() -> None:
    unbounded = ca.if_else(a < 0, ca.inf, -ca.inf) + ca.SX(0) * a
    lines = printed("t", {"z": a}, [unbounded], lambda n, i: f"{n}[{i}]", lambda k, i, v: f"o[{i}] = {v}")
    text = "\n".join(lines)
    assert "np.inf" in text and " inf" not in text
