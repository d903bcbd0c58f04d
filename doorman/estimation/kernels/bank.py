r"""A bank of filters that switch among hypotheses (interacting multiple model).

Within h, hypothesis i changes to j with the chance :math:`\pi_{ij} = (1 - e^{-s_i h})\,r_{ij} / s_i`, where :math:`r_{ij}` are
the rates of switching and :math:`s_i` their sum. Each filter begins with the mixture

.. math::
    c_j = \sum_i \pi_{ij} p_i,\quad \mu_i = \pi_{ij} p_i / c_j,\quad \bar x_j = \sum_i \mu_i x_i,\quad
    \bar P_j = \sum_i \mu_i \big(P_i + (x_i - \bar x_j)(x_i - \bar x_j)^T\big),

and what it finds likely changes its probability, :math:`p_j \propto c_j L_j` (Blom and Bar-Shalom 1988).
"""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.compilation import kernel
from doorman.estimation.kernels.memory import FilterMemory
from doorman.estimation.kernels.moments import FOUR, fuse_rows, has_meaning, predict, spread_of
from doorman.estimation.kernels.printed_functions import call_printed
from doorman.numba_types.lanes import load, store

_LOG_TURN = math.log(2.0 * math.pi)


@kernel
def advance(memory: FilterMemory, inputs: Array, h: float) -> None:
    """The bank after a time h with held inputs."""
    count = memory.means.shape[0]
    if count > 1:
        _mix(memory, inputs, h)
    for j in range(count):
        memory.logs[j] = 0.0
        if memory.weights[j] > 0.0:
            predict(memory, j, inputs, h)
            memory.logs[j] = _hold(memory, j, inputs, h)
    reweigh(memory)


@kernel
def _mix(memory: FilterMemory, inputs: Array, h: float) -> None:
    """Probabilities c after switching, and what each filter begins with."""
    count, n = memory.means.shape
    _find_chances(memory, inputs, h)
    for j in range(count):
        mean, covariance = memory.other_means[j], memory.other_covariances[j]
        reached = 0.0
        for i in range(count):
            reached += memory.chances[i, j]
        memory.logs[j] = reached
        for k in range(n):
            mean[k] = 0.0
            for i in range(count):
                if memory.chances[i, j] != 0.0:
                    mean[k] += memory.chances[i, j] / reached * memory.means[i, k]
        covariance[:, :] = 0.0
        for i in range(count):
            if memory.chances[i, j] != 0.0:
                share = memory.chances[i, j] / reached
                add_moments(memory, share, memory.means[i], memory.covariances[i], mean, covariance)
    for j in range(count):
        memory.weights[j] = memory.logs[j]
        if memory.weights[j] > 0.0:
            memory.means[j] = memory.other_means[j]
            memory.covariances[j] = memory.other_covariances[j]


@kernel
def _find_chances(memory: FilterMemory, inputs: Array, h: float) -> None:
    """Chance of having been i and being j now, π_ij p_i; NaN rates show in them."""
    count = memory.means.shape[0]
    for i in range(count):
        memory.chances[i] = 0.0
        if not memory.weights[i] > 0.0:
            continue
        call_printed(memory.switches.addresses[i], memory.means[i], inputs, memory.parameters, h, memory.out)
        total = 0.0
        for j in range(count):
            if j == i or memory.allowed[j] == 0.0 or memory.out[j] <= 0.0:
                memory.out[j] = 0.0
            total += memory.out[j]
        left = -np.expm1(-total * h)
        for j in range(count):
            if memory.out[j] != 0.0:
                memory.chances[i, j] = memory.weights[i] * left * memory.out[j] / total
        memory.chances[i, i] = memory.weights[i] * (1.0 - left)


@kernel
def _hold(memory: FilterMemory, j: int, inputs: Array, h: float) -> float:
    """Fuse what a hypothesis says for a time h: its log-likelihood."""
    holds = memory.holds
    rows, equalities = holds.rows[j], holds.equalities[j]
    if rows == 0:
        return 0.0
    call_printed(holds.addresses[j], memory.means[j], inputs, memory.parameters, h, memory.out)
    ends, columns, first, logarithm = holds.slope_ends[j], holds.slope_columns[j], 3 * rows, 0.0
    for row in range(rows):
        off, variance = memory.out[row], memory.out[rows + row]
        if row < equalities or not off >= 0.0:
            spread = spread_of(memory, memory.covariances[j], ends, columns, first, row)
            looks, excess = h / max(memory.out[2 * rows + row], h), off * off - spread
            if not excess <= 0.0:  # NaN counts, too
                logarithm -= 0.5 * looks * excess / (spread + variance)
    for row in range(equalities):
        memory.innovations[row] = -memory.out[row]
        memory.variances[row] = memory.out[rows + row] * max(memory.out[2 * rows + row] / h, 1.0)
    fuse_rows(memory, j, ends, columns, first, equalities)
    return logarithm


@kernel
def fuse(memory: FilterMemory, kind: int, values: Array, inputs: Array) -> bool:
    """Fuse a measurement at its own time; whether it passed the gate."""
    count = memory.means.shape[0]
    read, nearest = memory.measurements, np.inf
    rows = read.rows[kind, 0]
    for j in range(count):
        if memory.weights[j] > 0.0:
            memory.other_means[j] = memory.means[j]
            memory.other_covariances[j] = memory.covariances[j]
            call_printed(read.addresses[kind, j], memory.means[j], inputs, memory.parameters, 0.0, memory.out)
            for row in range(rows):
                memory.innovations[row] = values[row] - memory.out[row]
                memory.variances[row] = memory.out[rows + row]
            ends, columns = read.slope_ends[kind, j], read.slope_columns[kind, j]
            distance, spreads = fuse_rows(memory, j, ends, columns, 2 * rows, rows)
            memory.distances[j], memory.logs[j] = distance, -0.5 * (distance + spreads + rows * _LOG_TURN)
            if np.isfinite(memory.logs[j]):
                nearest = min(nearest, distance)
    if nearest == np.inf or nearest > memory.gates[kind]:
        for j in range(count):
            if memory.weights[j] > 0.0:
                memory.means[j] = memory.other_means[j]
                memory.covariances[j] = memory.other_covariances[j]
        memory.scores.refused[kind] += 1.0
        return False
    memory.progress.log_likelihood += reweigh(memory)
    memory.scores.fused[kind] += 1.0
    for j in range(count):
        if memory.weights[j] > 0.0:
            memory.scores.innovation[kind] += memory.weights[j] * memory.distances[j]
    return True


@kernel
def reweigh(memory: FilterMemory) -> float:
    """Probabilities by the log-likelihoods, zero for a filter that lost its meaning: log-likelihood of the bank."""
    best, total = -np.inf, 0.0
    for j in range(memory.weights.shape[0]):
        if memory.weights[j] == 0.0:
            continue
        if np.isfinite(memory.weights[j] + memory.logs[j]) and has_meaning(memory, j):
            memory.logs[j] += np.log(memory.weights[j])
            best = max(best, memory.logs[j])
        else:
            memory.weights[j] = 0.0
            memory.progress.broken += 1
    if best == -np.inf:
        return 0.0
    for j in range(memory.weights.shape[0]):
        if memory.weights[j] > 0.0:
            memory.weights[j] = np.exp(memory.logs[j] - best)
            total += memory.weights[j]
    for j in range(memory.weights.shape[0]):
        memory.weights[j] /= total
    return best + float(np.log(total))


@kernel
def prune(memory: FilterMemory) -> None:
    """Leave the allowed hypotheses; if none of them was likely, each begins with what the bank knows."""
    left, allowed = 0.0, 0.0
    for j in range(memory.weights.shape[0]):
        allowed += memory.allowed[j]
        left += memory.allowed[j] * memory.weights[j]
    if not left > 0.0:
        combine(memory)
    for j in range(memory.weights.shape[0]):
        if left > 0.0:
            memory.weights[j] *= memory.allowed[j] / left
        else:
            memory.weights[j] = memory.allowed[j] / allowed
            memory.means[j] = memory.mean
            memory.covariances[j] = memory.covariance


@kernel
def combine(memory: FilterMemory) -> None:
    """Mean and covariance of the whole bank."""
    count, n = memory.means.shape
    memory.mean[:] = 0.0
    memory.covariance[:, :] = 0.0
    for j in range(count):
        if memory.weights[j] > 0.0:
            for k in range(n):
                memory.mean[k] += memory.weights[j] * memory.means[j, k]
    for j in range(count):
        if memory.weights[j] > 0.0:
            add_moments(
                memory, memory.weights[j], memory.means[j], memory.covariances[j], memory.mean, memory.covariance
            )


@kernel
def add_moments(
    memory: FilterMemory, share: float, mean: Array, covariance: Array, of_all: Array, total: Array
) -> None:
    """Add one filter's share of a mixture's covariance."""
    away = memory.gain
    for k in range(mean.shape[0]):
        away[k] = mean[k] - of_all[k]
    for k in range(mean.shape[0]):
        own = away[k]
        for other in range(0, total.shape[1], 4):
            spread = load(covariance, (k, other), FOUR) + own * load(away, other, FOUR)
            store(total, (k, other), load(total, (k, other), FOUR) + share * spread)


@kernel
def combine_outputs(memory: FilterMemory) -> None:
    """Mean and variance of every output over the bank."""
    inputs = memory.kept_inputs[memory.progress.last % memory.kept_times.shape[0]]
    count = memory.means.shape[0]
    outputs = memory.outputs
    memory.output[:] = 0.0
    memory.output_variance[:] = 0.0
    for j in range(count):
        rows = outputs.rows[j]
        if memory.weights[j] > 0.0 and rows > 0:
            call_printed(outputs.addresses[j], memory.means[j], inputs, memory.parameters, 0.0, memory.out)
            ends, columns = outputs.slope_ends[j], outputs.slope_columns[j]
            for row in range(rows):
                value, weight = memory.out[row], memory.weights[j]
                spread = spread_of(memory, memory.covariances[j], ends, columns, rows, row)
                memory.output[row] += weight * value
                memory.output_variance[row] += weight * (spread + value * value)
    for row in range(memory.output.shape[0]):
        memory.output_variance[row] -= memory.output[row] ** 2


@kernel
def fill_report(memory: FilterMemory, report: Array) -> None:
    """Combine the bank, and tell all of it: mean, deviations, probabilities, outputs and theirs, covariance, and all means."""
    combine(memory)
    combine_outputs(memory)
    n, count, outputs = memory.mean.shape[0], memory.weights.shape[0], memory.output.shape[0]
    for i in range(n):
        report[i], report[n + i] = memory.mean[i], math.sqrt(memory.covariance[i, i])
    at = 2 * n
    for j in range(count):
        report[at + j] = memory.weights[j]
    at += count
    for row in range(outputs):
        variance = memory.output_variance[row]
        report[at + row], report[at + outputs + row] = (
            memory.output[row],
            math.sqrt(0.0 if variance < 0.0 else variance),
        )
    at += 2 * outputs
    for i in range(n):
        for j in range(n):
            report[at + i * n + j] = memory.covariance[i, j]
    at += n * n
    for j in range(count):
        for i in range(n):
            report[at + j * n + i] = memory.means[j, i]
