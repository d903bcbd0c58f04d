"""Active set of a trajectory's rows and bounds, and the multipliers that follow."""

from __future__ import annotations

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.solvers.memory.parts import Sides, Trajectory
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.sized import mark_node


@kernel
def mark_rows(
    k: int, rows: Array, multipliers: Array, scale: float, floors: Array, active: Sides, proposal: Array
) -> tuple[int, bool]:
    """Rows r ≤ 0 of one node: active where λ + r/μ > 0, with max(0, λ + r/μ) as their next multipliers."""
    count, flipped = 0, 0
    for i in range(floors.shape[0]):
        force, floor = multipliers[k, i] + scale * rows[k, i], floors[i]
        side = int(force > floor)
        proposal[k, i] = floor if force < floor else force
        flipped |= active[k, i] ^ side
        count += side
        active[k, i] = side
    return count, flipped != 0


@kernel
def classify(work: Workspace, at: Trajectory, penalty: float) -> int:
    """Active set {λ + r/μ > 0} and proposed multipliers max(0, λ + r/μ) at a trajectory's rows: the last node that changed."""
    active, multipliers, proposal, sizes = work.active, work.multipliers, work.proposal, work.sizes
    floors, last, n = work.floors, -1, at.inputs.shape[0]
    bounded = sizes.state_bounds + sizes.input_bounds > 0
    for k in range(n):
        stiff, h_changed, g_changed, changed = penalty * work.stiffness[k], False, False, False
        h, g = 0, 0
        if sizes.rows > 0:
            h, h_changed = mark_rows(k, at.rows, multipliers.rows, stiff, floors.rows, active.rows, proposal.rows)
        if sizes.input_rows > 0:
            g, g_changed = mark_rows(
                k, at.input_rows, multipliers.input_rows, penalty, floors.input_rows, active.input_rows,
                proposal.input_rows,
            )  # fmt: skip
        active.state_count[k], active.input_count[k] = h, g
        if bounded:
            changed = mark_node(work.tiles, k, work, at.states[k + 1], at.inputs[k], stiff, penalty)
        if h_changed or g_changed or changed:
            last = k
    one = (1, sizes.end_rows)
    end, end_changed = mark_rows(
        0, at.end_rows.reshape(one), multipliers.end_rows.reshape(one), penalty, floors.end_rows,
        active.end_rows.reshape(one), proposal.end_rows.reshape(one),
    )  # fmt: skip
    active.state_count[n - 1] += end  # they count as rows of the last state
    return n - 1 if end_changed else last
