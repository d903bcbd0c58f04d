"""Memory of the interior-point search, beside the workspace: problems that are solved without it have none."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.numba_types.records import Record
from doorman.ocp.solvers.iterations.filter import Filter
from doorman.ocp.solvers.memory.workspace import Workspace


class Numbers(Record):
    """Scalars of the search."""

    barrier: float
    """τ: s z at the centre."""
    scale: float
    """What counts as 1 of the cost."""
    infeasibility: float
    """θ: sum of defects and of |c + s|, without equalities."""
    barrier_cost: float
    """φ: J − τ Σ ln s + Σ (y c + w c²/2), the last of equalities."""
    slope: float
    """Slope of φ along the last Newton step."""
    primal: float
    """Longest step along which slacks stay positive."""
    dual: float
    """Longest step along which multipliers stay positive."""
    first: float
    """θ at the start."""
    tried: float
    """Regularisation with which an iteration goes on that has paused; 0 at its beginning."""
    penalty: float
    """w of the equalities."""
    unequal: float
    """Largest |c| of the equalities when their multipliers last moved."""


class Interior(NamedTuple):
    """Slacks and multipliers of all rows by node, and what a Newton step is made of.

    Rows are numbered as in `FlatRows`.
    """

    values: Array
    """c, (N + 1, rows)."""
    slacks: Array
    """s > 0, with c + s = 0 in the end."""
    duals: Array
    """z > 0; of equalities of either sign, y + w c."""
    estimates: Array
    """y of the equalities, which move where a barrier problem is solved."""
    slack_steps: Array
    dual_steps: Array
    costates: Array
    """Multipliers p of the defects f(x_k, u_k) − x_{k+1}, (N, nx)."""
    next_costates: Array
    """Those that the last Newton step proposes."""
    gradients: Array
    """Gradients of the cost by state and input, (N + 1, nx + nu)."""
    hessians: Array
    """Hessians of the Lagrangian, (N + 1, nx + nu, nx + nu)."""
    behind: Array
    """[V_xx | V_x] of state k + 1 with its rows, (N, nx, narrow)."""
    state_steps: Array
    """(N + 1, nx)."""
    input_steps: Array
    """(N, nu)."""
    residual: Array
    """Gradient of the Lagrangian at one node, (nx + nu,)."""
    filter: Filter
    """Of θ and φ."""
    numbers: Numbers

    @classmethod
    def of(cls, work: Workspace) -> Interior:
        """Memory for the sizes of a workspace."""
        n, nu = work.nominal.inputs.shape
        nx, narrow, rows = work.sizes.states, work.sizes.narrow, work.program.active.shape[1]
        values, slacks, duals, estimates, slack_steps, dual_steps = (np.zeros((n + 1, rows)) for _ in range(6))
        return cls(
            values=values, slacks=slacks, duals=duals, estimates=estimates, slack_steps=slack_steps, dual_steps=dual_steps,
            costates=np.zeros((n, nx)), next_costates=np.zeros((n, nx)),
            gradients=np.zeros((n + 1, nx + nu)), hessians=np.zeros((n + 1, nx + nu, nx + nu)),
            behind=np.zeros((n, nx, narrow)), state_steps=np.zeros((n + 1, nx)), input_steps=np.zeros((n, nu)),
            residual=np.zeros(nx + nu), filter=Filter(), numbers=Numbers(),
        )  # fmt: skip
