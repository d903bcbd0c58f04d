r"""Discrete dynamics from continuous ones, in symbols.

.. math::
    x^+ = x + \tfrac{\Delta t}{6}(k_1 + 2k_2 + 2k_3 + k_4)\ \text{(rk4)},\qquad x^+ = x + \Delta t\,\dot x(x, u)\ \text{(euler)}

A rate that depends on no state is integrated exactly by both.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import casadi as ca

Integrator = Literal["rk4", "euler", "discrete"]
INTEGRATORS: tuple[Integrator, ...] = ("rk4", "euler", "discrete")


def discretized(derivative: Callable[[Any], Any], x: Any, time_step: Any, integrator: Integrator, steps: int) -> Any:
    """State after a time step."""
    if integrator == "discrete":
        return derivative(x)
    h, rate = time_step / steps, derivative(x)
    steady = [row for row in range(x.numel()) if not ca.depends_on(rate[row], x)]
    first = x
    for _ in range(steps):
        k1 = derivative(x)
        if integrator == "euler":
            x = x + h * k1
            continue
        k2 = derivative(x + 0.5 * h * k1)
        k3 = derivative(x + 0.5 * h * k2)
        k4 = derivative(x + h * k3)
        x = x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    for row in steady:  # exactly, and with less work
        x[row] = first[row] + time_step * rate[row]
    return x
