r"""Second-order check of a solution: whether it is a minimum, or only a point where first-order conditions hold.

Gauss and Newton's Hessian is positive everywhere, so that iterations with it stop at saddle points, too. A solution is a minimum
where the Hessian of the Lagrangian is positive along all directions that keep its active rows. By the theorem of Finsler that
holds if and only if :math:`H + w\,C_a^T C_a` is positive definite for some weight w, which one Riccati sweep decides: all its
pivots are positive. Rows with a multiplier of nearly zero do not count as active.
"""

from __future__ import annotations

from doorman.compilation import kernel
from doorman.ocp.solvers.interior import newton
from doorman.ocp.solvers.interior.memory import Interior
from doorman.ocp.solvers.interior.rows import add_rows
from doorman.ocp.solvers.iterations.nominal import linearize
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.flat_rows import flatten_multipliers

_WEIGHT = 1e6
"""w, in units of the cost's scale."""
_ACTIVE = 1e-6
"""Least multiplier of an active row, in units of the cost's scale."""
_NONE = 1e-300
"""Multiplier of a row that is not active."""


@kernel
def is_minimum(model: object, work: Workspace, interior: Interior, scale: float) -> bool:
    """Check the nominal trajectory with its multipliers; overwrites the policy."""
    numbers = interior.numbers
    linearize(model, work)
    numbers.barrier, numbers.penalty = 0.0, _WEIGHT * scale
    flatten_multipliers(work, work.multipliers, interior.duals)
    for k in range(interior.duals.shape[0]):
        for i in range(interior.duals.shape[1]):
            if not work.flat.equal[i]:
                interior.duals[k, i] = max(0.0, interior.duals[k, i])
    accumulate_costates(model, work, interior)
    newton.expand(model, work, interior)
    for k in range(interior.duals.shape[0]):
        for i in range(interior.duals.shape[1]):
            dual = interior.duals[k, i]
            active = dual > _ACTIVE * scale
            interior.slacks[k, i] = dual / (_WEIGHT * scale) if active else 1.0
            if not (active or work.flat.equal[i]):
                interior.duals[k, i] = _NONE
            interior.values[k, i] = 0.0
            interior.estimates[k, i] = 0.0
    return newton.sweep(work, interior, 0.0)


@kernel
def accumulate_costates(model: object, work: Workspace, interior: Interior) -> None:
    """Multipliers of the dynamics, from the last node back: p_k = ∂ℓ/∂x + Aᵀ p + the rows' share, all at state k + 1."""
    nx, n, costates, r = work.sizes.states, work.nominal.inputs.shape[0], interior.costates, interior.residual
    costates[:, :] = 0.0
    newton.expand(model, work, interior)  # gradients of the cost, which do not depend on costates
    for k in range(n - 1, -1, -1):
        for i in range(nx):
            r[i] = interior.gradients[k + 1, i]
        add_rows(work, interior, k + 1)
        for i in range(nx):
            costates[k, i] = r[i]
        if k < n - 1:
            for i in range(nx):
                share = costates[k + 1, i]
                for j in range(nx):
                    costates[k, j] += work.linear.jacobians[k + 1, i, j] * share
