"""First guesses: a blind rollout, integrators made consistent, the previous plan shifted to where the state is now."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.ocp.kernels.functions import at_node, step
from doorman.ocp.kernels.python_functions import LARGEST_STATE
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.sized import multiply_dynamics, multiply_gains


@kernel
def settle_integrators(work: Workspace) -> None:
    """Set the integrators of the nominal trajectory by its first state and its inputs."""
    nx, nu, m = work.sizes.states, work.sizes.inputs, work.sizes.integrators
    states, inputs, dt = work.nominal.states, work.nominal.inputs, work.weights.time_step
    if m > 0:
        for k in range(inputs.shape[0]):
            for i in range(m):
                states[k + 1, nx - m + i] = states[k, nx - m + i] + dt * inputs[k, nu - m + i]


@kernel
def roll_blindly(model: object, work: Workspace, first: int) -> None:
    """Set the nominal states after node `first` by the dynamics; they are held where they stop being finite."""
    states, inputs = work.nominal.states, work.nominal.inputs
    for k in range(first, inputs.shape[0]):
        step(at_node(model, k), states[k], inputs[k], states[k + 1])
        finite = True
        for i in range(states.shape[1]):
            finite &= abs(states[k + 1, i]) < LARGEST_STATE
        if not finite:
            for j in range(k, inputs.shape[0]):
                for i in range(states.shape[1]):
                    states[j + 1, i] = states[k, i]
            settle_integrators(work)
            return


@kernel
def aim_straight(work: Workspace) -> None:
    """Set the nominal states on the straight line to the goal, and inputs of integrators to the rate that leads there."""
    nx, nu, m = work.sizes.states, work.sizes.inputs, work.sizes.integrators
    states, inputs, goal, limits = work.nominal.states, work.nominal.inputs, work.weights.state_goal, work.limits
    n = inputs.shape[0]
    for k in range(n):
        part = (k + 1.0) / n
        for i in range(nx):
            states[k + 1, i] = (1.0 - part) * states[0, i] + part * goal[i]
        for i in range(m):
            rate = (goal[nx - m + i] - states[0, nx - m + i]) / (n * work.weights.time_step)
            inputs[k, nu - m + i] = min(max(rate, limits.input_lower[nu - m + i]), limits.input_upper[nu - m + i])
    settle_integrators(work)


@kernel
def nearest_shift(states: Array, state: Array, weights: Array, limit: int) -> float:
    """Number of steps along `states` at which its polyline is nearest to `state`."""
    best, shift = np.inf, 0.0
    for k in range(min(limit, states.shape[0] - 1)):
        along, length = 0.0, 1e-300
        for i in range(state.shape[0]):
            edge = states[k + 1, i] - states[k, i]
            along += weights[i] * edge * (state[i] - states[k, i])
            length += weights[i] * edge * edge
        part = min(max(along / length, 0.0), 1.0)
        distance = 0.0
        for i in range(state.shape[0]):
            gap = state[i] - states[k, i] - part * (states[k + 1, i] - states[k, i])
            distance += weights[i] * gap * gap
        if distance < best:
            best, shift = distance, k + part
    return shift


@kernel
def shift_rows(rows: Array, shift: float) -> None:
    """Rows of a trajectory `shift` steps later, in place, linearly interpolated; the last row is held."""
    last = rows.shape[0] - 1
    whole = int(shift)
    part = shift - whole
    for k in range(rows.shape[0]):
        first, second = min(k + whole, last), min(k + whole + 1, last)
        for j in range(rows.shape[1]):
            rows[k, j] = (1.0 - part) * rows[first, j] + part * rows[second, j]


@kernel
def shift_guess(model: object, work: Workspace, state: Array, shift: float, limit: int) -> None:
    """Shift states, inputs and multipliers of the nominal trajectory to begin at `state`.

    It goes on at its end with the last inputs, by the dynamics. Multipliers of the last node stay there: with no future behind
    it, they are not those of its neighbours. Without either the active set at the end flips in every replan.
    """
    if shift < 0.0:
        shift = nearest_shift(work.nominal.states, state, work.weights.state, limit)
    if shift > 0.0:
        shift_rows(work.nominal.states, shift)
        shift_rows(work.nominal.inputs, shift)
        shift_rows(work.multipliers.rows[:-1], shift)
        shift_rows(work.multipliers.input_rows, shift)
        shift_rows(work.multipliers.states[:-1], shift)
        shift_rows(work.multipliers.inputs, shift)
        roll_blindly(model, work, max(work.nominal.inputs.shape[0] - int(np.ceil(shift)), 0))
    lead_to(work, state, shift)
    for i in range(state.shape[0]):
        work.nominal.states[0, i] = state[i]
    settle_integrators(work)


@kernel
def lead_to(work: Workspace, state: Array, shift: float) -> None:
    """Bend the shifted trajectory towards another first state, to first order: by the last sweep's feedback and dynamics.

    That keeps to the rows which were active in the sweep, where a first state that jumps would violate them all along.
    """
    nx, nu, step, nominal = work.sizes.states, work.sizes.inputs, work.node.step, work.nominal
    n, whole = nominal.inputs.shape[0], int(shift + 0.5)
    step[:] = 0.0
    for i in range(nx):
        step[i] = state[i] - nominal.states[0, i]
    for k in range(n):
        of_plan = min(k + whole, n - 1)
        step[nx] = 0.0
        for i in range(nu):
            step[nx + 1 + i] = 0.0
        multiply_gains(work.tiles, of_plan, work)
        for i in range(nu):
            value = nominal.inputs[k, i] + step[nx + 1 + i]
            if work.sizes.input_bounds > 0:
                value = min(max(value, work.limits.input_lower[i]), work.limits.input_upper[i])
            step[nx + 1 + i] = value - nominal.inputs[k, i]
            nominal.inputs[k, i] = value
        multiply_dynamics(work.tiles, of_plan, work)
        for i in range(nx):
            nominal.states[k + 1, i] += step[i]
