r"""Process models: how the state of a filter moves, in CasADi expressions.

.. math:: \dot x = f(x, u, p) + G(x, u, p)\,w,\qquad \mathrm{E}[w(t)\,w(s)^T] = I\,\delta(t - s)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from doorman.estimation.expressions import checked_column, checked_symbols
from doorman.exceptions import DimensionError, DoormanError
from doorman.ocp.problem.integrators import INTEGRATORS, Integrator, discretized


@dataclass(frozen=True, eq=False)
class ProcessModel:
    r"""Rate of change of a state, and the noise that drives it.

    After a time h with held inputs the mean is that of the integrator, and the covariance is
    :math:`P^+ = F P F^T + h\,G G^T` with :math:`F = \partial x^+ / \partial x`.

    Args:
        state: Symbols x, (n, 1) CasADi SX.
        inputs: Symbols u, (m, 1): commands, and what is measured well enough to be taken as known.
        dynamics: f of these symbols, (n, 1).
        noise: Deviation of each state after one second of this noise alone, (n, 1) [unit of x/√s], or G, (n, any). Noise of an
            input with density s enters as the column ``ca.jacobian(dynamics, u_i) * s``.
        parameters: Symbols p of numbers that change without compiling, (np, 1).
        integrator: "euler" or "rk4", or "discrete" where `dynamics` is x⁺ of x, u, p and `time_step`.
        steps: Equal integration steps of a time step.
        time_step: Symbol h of the time step [s], for "discrete".
        lower: Least value of each state, to which the mean is put back; none where −inf.
        upper: Largest value of each state.

    Raises:
        DoormanError: if an expression contains an unknown symbol, or a size does not fit.
    """

    state: Any
    inputs: Any
    dynamics: Any
    noise: Any
    parameters: Any = None
    integrator: Integrator = "euler"
    steps: int = 1
    time_step: Any = None
    lower: ArrayLike | None = None
    upper: ArrayLike | None = None

    def __post_init__(self) -> None:
        def settle(name: str, value: Any) -> None:
            object.__setattr__(self, name, value)

        empty = ca.SX(0, 1)
        for name in ("state", "inputs", "parameters"):
            given = getattr(self, name)
            settle(name, checked_symbols(name, empty if given is None else given))
        settle("time_step", ca.SX.sym("time_step") if self.time_step is None else self.time_step)
        if self.integrator not in INTEGRATORS:
            raise DoormanError("unknown", field="integrator", given=self.integrator, allowed=", ".join(INTEGRATORS))
        settle("dynamics", self.checked_dynamics("dynamics", self.dynamics))
        settle("noise", self.checked_noise("noise", self.noise))
        for name, none in (("lower", -np.inf), ("upper", np.inf)):
            ends = np.full(self.size, none) if getattr(self, name) is None else np.array(getattr(self, name), float)
            if ends.shape != (self.size,) or np.isnan(ends).any():
                raise DimensionError("not an end of each state", field=name, given=ends, allowed=f"({self.size},)")
            ends.setflags(write=False)
            settle(name, ends)

    @property
    def size(self) -> int:
        """Number n of states."""
        return int(self.state.numel())

    @property
    def symbols(self) -> Any:
        """All symbols that an expression of this model may use, in a column."""
        return ca.vertcat(self.state, self.inputs, self.parameters)

    def step(self, dynamics: Any) -> Any:
        """State x⁺ after the time step with these dynamics, (n, 1)."""
        rate = ca.Function("rate", [self.state, ca.vertcat(self.inputs, self.parameters, self.time_step)], [dynamics])
        held = ca.vertcat(self.inputs, self.parameters, self.time_step)
        return discretized(lambda x: rate(x, held), self.state, self.time_step, self.integrator, self.steps)

    def checked_dynamics(self, field: str, given: Any) -> Any:
        """Dynamics of all states, of known symbols."""
        known = ca.vertcat(self.symbols, self.time_step) if self.integrator == "discrete" else self.symbols
        return checked_column(field, given, known, self.size)

    def checked_noise(self, field: str, given: Any) -> Any:
        """G, (n, any)."""
        if isinstance(given, (ca.SX, ca.DM)) and given.shape[1] > 1 and given.shape[0] == self.size:
            checked_column(field, given, self.symbols)
            return ca.SX(given)
        return ca.diag(checked_column(field, given, self.symbols, self.size))
