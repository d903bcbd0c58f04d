r"""The careful phase of the augmented Lagrangian: a merit function, and multipliers that move only once a step has settled.

For the present multipliers and penalty, steps have to lower

.. math:: m = J + \tfrac{\mu}{2}\sum_i\big(\max(0, \lambda_i + h_i/\mu)^2 - \lambda_i^2\big) + \rho\,\lVert e\rVert_1

by Armijo's rule, ρ above the largest costate of the present sweep. At every length the step is tried twice: rolled out on the
dynamics with the sweep's feedback, which leaves no defects, and as the straight move of states and inputs. Where the dynamics
bend much the first goes further; from a guess that is no trajectory only the second leads anywhere. Multipliers and penalty
follow the rules of bound-constrained Lagrangian methods (Conn, Gould and Toint 1991). Slower than
`augmented_lagrangian.iterate`, and reliable where that is not.
"""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.numba_types.clock import clock
from doorman.ocp.kernels.functions import at_node, step
from doorman.ocp.kernels.python_functions import LARGEST_STATE
from doorman.ocp.solvers.iterations.augmented_lagrangian import (
    ACCURACY,
    CONVERGED,
    FAILED,
    OUT_OF_ITERATIONS,
    PAUSED,
    STALLED,
    direction,
    regularize,
)
from doorman.ocp.solvers.iterations.nominal import (
    evaluate_rows,
    go_back,
    linearize,
    measure_nominal,
    move,
    save,
    take_multipliers,
    total_cost,
)
from doorman.ocp.solvers.memory.workspace import Workspace
from doorman.ocp.solvers.sweeps.active_set import classify
from doorman.ocp.solvers.sweeps.flat_rows import flatten_multipliers, flatten_values

_FIRST_PENALTY = 30.0
"""1/μ to begin with where nothing is known yet."""
_LARGEST_PENALTY = 1e5
_SWEEPS = 12
_FIRST_SETTLED = 1.0
"""A step with a smaller predicted decrease, relative to 1 + |J|, moves the multipliers;"""
_SETTLED_SHARE = 0.3
"""this share of it the next time."""
_SLOW = 0.25
"""Where violations do not fall to this share from one update of the multipliers to the next, they have to cost more."""
_HALVINGS = 9


@kernel
def merit(model: object, work: Workspace, penalty: float, weight: float) -> float:
    """Merit m of the nominal trajectory after its linearisation; its cost goes into `result`."""
    flat, total, defects, nx = work.flat, 0.0, 0.0, work.sizes.states
    flatten_values(work, work.nominal, flat.values)
    flatten_multipliers(work, work.multipliers, flat.prices)
    for k in range(flat.values.shape[0]):
        for i in range(flat.values.shape[1]):
            if flat.applies[k, i]:
                price, factor = flat.prices[k, i], flat.stiffness[k, i]
                force = price + penalty * factor * flat.values[k, i]
                if not flat.equal[i]:
                    price = max(0.0, price)
                    if force <= 0.0:  # not for NaN, which has to show
                        force = 0.0
                total += (force * force - price * price) / factor
    for k in range(work.nominal.inputs.shape[0] if weight > 0.0 else 0):
        for i in range(nx):
            defects += abs(work.linear.jacobians[k, i, nx])
    work.result.cost = total_cost(model, work, work.nominal)
    return float(work.result.cost + 0.5 * total / penalty + weight * defects)


@kernel
def roll(model: object, work: Workspace, scale: float) -> bool:
    """Nominal trajectory by the policy around `saved`, on the dynamics and inside the inputs' bounds."""
    nx, nominal, saved, gains, limits = work.sizes.states, work.nominal, work.saved, work.policy.gains, work.limits
    for k in range(nominal.inputs.shape[0]):
        for a in range(work.sizes.inputs):
            total = saved.inputs[k, a] + scale * gains[k, a, nx]
            for j in range(nx):
                total += gains[k, a, j] * (nominal.states[k, j] - saved.states[k, j])
            if work.sizes.input_bounds > 0:
                total = min(max(total, limits.input_lower[a]), limits.input_upper[a])
            nominal.inputs[k, a] = total
        step(at_node(model, k), nominal.states[k], nominal.inputs[k], nominal.states[k + 1])
        for i in range(nx):
            if not abs(nominal.states[k + 1, i]) < LARGEST_STATE:
                return False
    return True


@kernel
def rolled_merit(model: object, work: Workspace, penalty: float, scale: float) -> float:
    """Merit m of the step rolled out into the nominal trajectory, without derivatives; ∞ where it is not finite."""
    if not roll(model, work, scale):
        return np.inf
    evaluate_rows(model, work, work.nominal)
    return float(merit(model, work, penalty, 0.0))


@kernel
def descend(model: object, work: Workspace, penalty: float, weight: float, before: float, deadline: float) -> float:
    """Shorten the step in `trial` until the merit has fallen enough."""
    expected = work.result.decrease
    save(work)
    scale = 1.0
    for _ in range(_HALVINGS):
        enough = before - 1e-4 * scale * expected + 1e-12 * (1.0 + abs(before))
        if rolled_merit(model, work, penalty, scale) <= enough:
            linearize(model, work)
            return scale
        move(work, scale)
        linearize(model, work)
        if merit(model, work, penalty, weight) <= enough:
            return scale
        if clock() > deadline:
            break
        scale *= 0.5
    go_back(model, work)
    return 0.0


@kernel
def is_solved(work: Workspace, merit: float) -> bool:
    """Whether the nominal trajectory needs no further step.

    Violations may stay where multipliers cannot grow any more.
    """
    result, tolerance, feasibility = work.result, work.settings.tolerance, work.settings.feasibility
    scale = 1.0 + abs(result.cost)
    if result.decrease > tolerance * scale or result.defect > feasibility:
        return False
    if result.priced_out:
        return True
    return bool(result.violation <= feasibility and abs(merit - result.cost) <= ACCURACY * scale)


@kernel
def iterate_carefully(model: object, work: Workspace, max_iterations: int, deadline: float) -> int:
    """Iterate from the nominal trajectory and the multipliers in `work`."""
    result, first = work.result, 0
    begun, slowest = clock(), 0.0
    if result.resumes:
        first = result.iterations
    else:
        result.penalty, result.regularization = _FIRST_PENALTY, 0.0
        result.settle, result.violation_before = _FIRST_SETTLED, np.inf
        result.iterations, result.priced_out = 0, False
        linearize(model, work)
    for iteration in range(first, max_iterations):
        if iteration > first and clock() > result.pause:
            return PAUSED
        now = clock()
        begun, slowest = now, max(slowest, now - begun)
        if iteration > 0 and now + slowest > deadline:
            return OUT_OF_ITERATIONS
        result.iterations = iteration + 1
        measure_nominal(work)
        classify(work, work.nominal, result.penalty)
        limit, regularization = deadline if iteration > 0 else np.inf, result.regularization
        if not direction(model, work, result.penalty, _SWEEPS, regularization, limit):
            return FAILED
        if not abs(result.infeasibility + result.change) < np.inf:
            return FAILED
        weight = 1.5 * result.costate
        before = merit(model, work, result.penalty, weight)
        if result.settled and regularization == 0.0 and is_solved(work, before):
            take_multipliers(work, 1.0)
            return CONVERGED
        expected, violation = result.decrease, result.violation
        scale = descend(model, work, result.penalty, weight, before, deadline)
        if not regularize(work, scale > 0.0):
            return STALLED
        if scale > 0.0 and result.settled and expected <= result.settle * (1.0 + abs(result.cost)):
            move_multipliers(work, scale, violation)
    return OUT_OF_ITERATIONS


@kernel
def move_multipliers(work: Workspace, scale: float, violation: float) -> None:
    """Take the multipliers that a settled step proposes; the penalty grows where violations do not fall."""
    result = work.result
    if scale < 1.0:
        classify(work, work.nominal, result.penalty)
    take_multipliers(work, 1.0)
    result.settle = max(_SETTLED_SHARE * result.settle, work.settings.tolerance)
    if violation > max(_SLOW * result.violation_before, work.settings.feasibility):
        result.penalty = min(4.0 * result.penalty, _LARGEST_PENALTY)
    result.violation_before = violation
