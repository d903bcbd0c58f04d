r"""Semismooth augmented Lagrangian: the fast iterations before CDDP, which finds a whole active set at once.

Gauss-Newton on the multiple-shooting form: states and inputs are variables, defects :math:`e_k = f(x_k,u_k) - x_{k+1}` stay in
the affine term. Each row h ≤ 0 has a multiplier λ ≥ 0 and a penalty 1/μ; the active rows are those with λ + h/μ > 0:

.. math::
    V_{xx} \mathrel{+}= \tfrac1\mu h_x^T h_x,\qquad V_x \mathrel{+}= h_x^T(\lambda + h/\mu),\qquad
    \lambda \leftarrow \max(0,\ \lambda + r/\mu),\quad r = h + h_x\,\delta x

After a sweep the whole active set flips to {λ + r/μ > 0}, a semismooth Newton step; if it changed, the sweep is repeated on
the same linearisation. Methods: Jallet et al. 2022 (proximal AL DDP); Hintermüller, Ito and Kunisch 2003 (active sets).
"""

from __future__ import annotations

from doorman.compilation import kernel
from doorman.ocp.functions import linearize_constraints, linearize_step, step
from doorman.ocp.riccati import eliminate, expand, substitute, terminal_value
from doorman.ocp.workspace import Workspace

CONVERGED = 0
OUT_OF_ITERATIONS = 1
FAILED = 2


@kernel
def linearize_shooting(model: object, work: Workspace) -> float:
    """Dynamics with defects, and constraints, along the nominal trajectory; largest defect."""
    nx, nu = len(work.sizes.states), len(work.sizes.inputs)
    states, inputs, constraints = work.nominal.states, work.nominal.inputs, work.nominal.constraints
    worst = 0.0
    for k in range(inputs.shape[0]):
        jacobian = work.policy.jacobians[k]
        linearize_step(model, states[k], inputs[k], jacobian)
        step(model, states[k], inputs[k], work.trial.states[k + 1])
        for i in range(nx):
            defect = work.trial.states[k + 1, i] - states[k + 1, i]
            jacobian[i, nx + nu] = defect
            worst = max(worst, abs(defect))
        linearize_constraints(model, states[k + 1], constraints[k], work.policy.constraint_jacobians[k])
    return worst


@kernel
def penalize(work: Workspace, k: int, penalty: float) -> None:
    """Add the active rows of state k + 1 to its value function."""
    nx, nu, nh = len(work.sizes.states), len(work.sizes.inputs), len(work.sizes.constraints)
    value, slopes = work.scratch.value, work.policy.constraint_jacobians[k]
    for i in range(nh):
        if work.policy.active[k, i]:
            force = work.policy.multipliers[k, i] + penalty * work.nominal.constraints[k, i]
            for a in range(nx):
                scale = penalty * slopes[i, a]
                value[a, nx + nu] += slopes[i, a] * force
                if scale != 0.0:
                    for b in range(nx):
                        value[a, b] += scale * slopes[i, b]


@kernel
def sweep(work: Workspace, penalty: float) -> bool:
    """Riccati sweep with the penalties of the active rows; False if it breaks down."""
    terminal_value(work)
    for k in range(work.nominal.inputs.shape[0] - 1, -1, -1):
        penalize(work, k, penalty)
        expand(work, k, 0.0)
        if not eliminate(work, k):
            return False
        substitute(work, k, work.scratch.half)
    return True


@kernel
def step_along(work: Workspace, penalty: float) -> bool:
    """Newton step into the trial trajectory, linearised rows r into its constraints; True if the active set flipped."""
    nx, nu, nh = len(work.sizes.states), len(work.sizes.inputs), len(work.sizes.constraints)
    nominal, trial, policy, change = work.nominal, work.trial, work.policy, work.scratch.linearization[0]
    flipped = False
    largest = 0.0
    for i in range(nx):
        trial.states[0, i] = nominal.states[0, i]
    for k in range(nominal.inputs.shape[0]):
        gains, jacobian = policy.gains[k], policy.jacobians[k]
        for a in range(nu):
            total = gains[a, nx + nu]
            for j in range(nx):
                total += gains[a, j] * (trial.states[k, j] - nominal.states[k, j])
            trial.inputs[k, a] = nominal.inputs[k, a] + total
            largest = max(largest, work.weights.input[a] * abs(total))
        for i in range(nx):
            total = jacobian[i, nx + nu]
            for j in range(nx):
                total += jacobian[i, j] * (trial.states[k, j] - nominal.states[k, j])
            for a in range(nu):
                total += jacobian[i, nx + a] * (trial.inputs[k, a] - nominal.inputs[k, a])
            change[i] = total
            trial.states[k + 1, i] = nominal.states[k + 1, i] + total
        for i in range(nh):
            residual = nominal.constraints[k, i]
            for j in range(nx):
                residual += policy.constraint_jacobians[k, i, j] * change[j]
            trial.constraints[k, i] = residual
            active = policy.multipliers[k, i] + penalty * residual > 0.0
            if active != policy.active[k, i]:
                policy.active[k, i] = active
                flipped = True
    work.scratch.result[3] = largest
    return flipped


@kernel
def accept_step(work: Workspace, penalty: float) -> None:
    """Full step on states, inputs and multipliers."""
    nominal, trial, policy = work.nominal, work.trial, work.policy
    for k in range(nominal.inputs.shape[0]):
        for a in range(nominal.inputs.shape[1]):
            nominal.inputs[k, a] = trial.inputs[k, a]
        for i in range(nominal.states.shape[1]):
            nominal.states[k + 1, i] = trial.states[k + 1, i]
        for i in range(nominal.constraints.shape[1]):
            multiplier = policy.multipliers[k, i] + penalty * trial.constraints[k, i]
            policy.multipliers[k, i] = multiplier if policy.active[k, i] and multiplier > 0.0 else 0.0


@kernel
def iterate(model: object, work: Workspace, penalty: float, max_iterations: int, sweeps: int, tolerance: float) -> int:
    """Iterate from the nominal trajectory and the multipliers in `work`.

    Args:
        model: The problem's model.
        work: Workspace; its nominal trajectory need not satisfy the dynamics.
        penalty: 1/μ.
        max_iterations: Largest number of linearisations.
        sweeps: Largest number of Riccati sweeps on one linearisation.
        tolerance: Converged when no input changes by more than this, weighted by its cost, the defects are as small, and
            the active set stays.

    Returns:
        CONVERGED, OUT_OF_ITERATIONS or FAILED; the number of iterations is in `work.scratch.result[1]`.
    """
    policy = work.policy
    for iteration in range(max_iterations):
        defect = linearize_shooting(model, work)
        work.scratch.result[1] = iteration + 1.0
        if not defect < 1e3:
            return FAILED
        for k in range(policy.multipliers.shape[0]):
            for i in range(policy.multipliers.shape[1]):
                policy.active[k, i] = policy.multipliers[k, i] + penalty * work.nominal.constraints[k, i] > 0.0
        flipped = True
        for _ in range(sweeps):
            if not sweep(work, penalty):
                return FAILED
            flipped = step_along(work, penalty)
            if not flipped:
                break
        accept_step(work, penalty)
        if not work.scratch.result[3] < 1e6:
            return FAILED
        if not flipped and work.scratch.result[3] < tolerance and defect < tolerance:
            return CONVERGED
    return OUT_OF_ITERATIONS
