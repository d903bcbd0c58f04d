"""Rows and bounds of all nodes in one numbering, that of `Program`: h, h_N, g, then one for every finite bound.

Rows and bounds of a state stand at its own node, (N + 1, rows). Kernels that treat all kinds alike read them here.
"""

from __future__ import annotations

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.solvers.memory.parts import Multipliers, Trajectory
from doorman.ocp.solvers.memory.workspace import Workspace


@kernel
def flatten_values(work: Workspace, at: Trajectory, out: Array) -> None:
    """Values of all rows along a trajectory, positive where they are violated."""
    program, n = work.program, at.inputs.shape[0]
    nx, nh, nt, ng = work.sizes.states, work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    for k in range(n + 1):
        for i in range(nh if k > 0 else 0):
            out[k, i] = at.rows[k - 1, i]
        for i in range(nt if k == n else 0):
            out[k, nh + i] = at.end_rows[i]
        for i in range(ng if k < n else 0):
            out[k, nh + nt + i] = at.input_rows[k, i]
        for i in range(program.bounded.shape[0]):
            a, place = program.bounded[i], nh + nt + ng + i
            if work.flat.applies[k, place]:
                number = at.states[k, a] if a < nx else at.inputs[k, a - nx]
                out[k, place] = program.side[i] * (number - program.limit[i])


@kernel
def flatten_multipliers(work: Workspace, given: Multipliers, out: Array) -> None:
    """Multipliers of all rows; of bounds with their signs, negative where the other end pushes."""
    program, n = work.program, given.inputs.shape[0]
    nx, nh, nt, ng = work.sizes.states, work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    out[:, :] = 0.0
    for k in range(n + 1):
        for i in range(nh if k > 0 else 0):
            out[k, i] = given.rows[k - 1, i]
        for i in range(nt if k == n else 0):
            out[k, nh + i] = given.end_rows[i]
        for i in range(ng if k < n else 0):
            out[k, nh + nt + i] = given.input_rows[k, i]
        for i in range(program.bounded.shape[0]):
            a, place = program.bounded[i], nh + nt + ng + i
            if work.flat.applies[k, place]:
                out[k, place] = program.side[i] * (given.states[k - 1, a] if a < nx else given.inputs[k, a - nx])


@kernel
def store_multipliers(work: Workspace, given: Array, of_state: int, of_input: int) -> None:
    """Write multipliers of the rows of state `of_state` + 1 and of input `of_input`, where they are not −1; bounds are added."""
    program, out, last = work.program, work.multipliers, work.nominal.inputs.shape[0] - 1
    nx, nh, nt, ng = work.sizes.states, work.sizes.rows, work.sizes.end_rows, work.sizes.input_rows
    for i in range(nh if of_state >= 0 else 0):
        out.rows[of_state, i] = given[i]
    for i in range(nt if of_state == last else 0):
        out.end_rows[i] = given[nh + i]
    for i in range(ng if of_input >= 0 else 0):
        out.input_rows[of_input, i] = given[nh + nt + i]
    for i in range(program.bounded.shape[0]):
        a, price = program.bounded[i], program.side[i] * given[nh + nt + ng + i]
        if a < nx and of_state >= 0:
            out.states[of_state, a] += price
        elif a >= nx and of_input >= 0:
            out.inputs[of_input, a - nx] += price
