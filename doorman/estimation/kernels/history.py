"""A bank through time: ticks and measurements are kept, and what comes late is fused at its own time.

A step goes back to the last tick before the oldest new measurement, and repeats all that came since: inputs as they were held,
measurements in the order of their stamps. The result is the same as if all had come in time, to the bit.
"""

from __future__ import annotations

import numpy as np

from doorman.compilation import kernel
from doorman.estimation.kernels.bank import advance, fuse, prune
from doorman.estimation.kernels.memory import FilterMemory

OK, REFUSED, DROPPED, TOO_OLD, TOO_MANY, CLOCK, NOT_FINITE, NOT_STARTED, LOST = range(9)
"""As in `Status`."""


@kernel
def start(memory: FilterMemory, time: float) -> None:
    """Begin with the bank as it is."""
    progress, scores = memory.progress, memory.scores
    progress.first = progress.last = progress.stored = 0
    progress.running = 1
    progress.oldest_new = np.inf
    progress.log_likelihood = 0.0
    scores.fused[:] = scores.refused[:] = scores.innovation[:] = 0.0
    memory.kept_times[0] = time
    memory.kept_inputs[0] = memory.coming
    memory.kept_allowed[0] = memory.allowed
    _keep(memory, 0)


@kernel
def store(memory: FilterMemory, kind: int, time: float, count: int) -> int:
    """Take a measurement for the next step."""
    progress, stored = memory.progress, memory.progress.stored
    if progress.running == 0:
        return NOT_STARTED
    if not np.isfinite(time):
        return NOT_FINITE
    for i in range(count):
        if not np.isfinite(memory.reading[i]):
            return NOT_FINITE
    ticks = memory.kept_times.shape[0]
    if time <= memory.kept_times[progress.first % ticks]:
        return TOO_OLD
    if time > memory.kept_times[progress.last % ticks] + memory.progress.longest_step:
        return CLOCK
    if stored == memory.stamps.shape[0]:
        return TOO_MANY
    at = stored
    while at > 0 and (memory.stamps[at - 1] > time or (memory.stamps[at - 1] == time and memory.kinds[at - 1] > kind)):
        _copy_stored(memory, at - 1, at)
        at -= 1
    memory.stamps[at], memory.kinds[at], memory.was_refused[at] = time, kind, 0
    for i in range(count):
        memory.values[at, i] = memory.reading[i]
    progress.stored = stored + 1
    progress.oldest_new = min(progress.oldest_new, time)
    return OK


@kernel
def step(memory: FilterMemory, time: float) -> int:
    """Bring the bank to a time from which on other inputs act; the worst of what happened on the way."""
    progress, ticks = memory.progress, memory.kept_times.shape[0]
    if progress.running == 0:
        return NOT_STARTED
    if not np.isfinite(time):
        return NOT_FINITE
    for value in memory.coming:
        if not np.isfinite(value):
            return NOT_FINITE
    last = progress.last
    now = memory.kept_times[last % ticks]
    if not (time > now and time - now <= memory.progress.longest_step):
        return CLOCK
    memory.kept_times[(last + 1) % ticks] = time
    memory.kept_inputs[(last + 1) % ticks] = memory.coming
    memory.kept_allowed[(last + 1) % ticks] = memory.kept_allowed[last % ticks]
    tick, worst = last, OK
    while tick > progress.first and memory.kept_times[tick % ticks] >= memory.progress.oldest_new:
        tick -= 1
    memory.progress.oldest_new, progress.broken = np.inf, 0
    _restore(memory, tick)
    while tick <= last:
        worst = max(worst, _to_next_tick(memory, tick))
        if worst == LOST:
            progress.running = 0
            return LOST
        tick += 1
        _keep(memory, tick)
    progress.last = last + 1
    progress.first = max(progress.first, last + 3 - ticks)
    _forget(memory, memory.kept_times[progress.first % ticks])
    return worst


@kernel
def _to_next_tick(memory: FilterMemory, tick: int) -> int:
    """From one tick to the next, with all measurements between them."""
    ticks = memory.kept_times.shape[0]
    now, end = memory.kept_times[tick % ticks], memory.kept_times[(tick + 1) % ticks]
    inputs, worst, at = memory.kept_inputs[tick % ticks], OK, 0
    memory.allowed[:] = memory.kept_allowed[tick % ticks]
    prune(memory)
    while at < memory.progress.stored and memory.stamps[at] <= now:
        at += 1
    while at < memory.progress.stored and memory.stamps[at] <= end:
        if memory.stamps[at] > now:
            advance(memory, inputs, memory.stamps[at] - now)
            now = memory.stamps[at]
        passed = fuse(memory, memory.kinds[at], memory.values[at], inputs)
        if not passed and memory.was_refused[at] == 0:
            worst = max(worst, REFUSED)
        memory.was_refused[at] = 0 if passed else 1
        at += 1
    if end > now:
        advance(memory, inputs, end - now)
    if memory.progress.broken > 0:
        worst = max(worst, DROPPED)
    for weight in memory.weights:
        if weight > 0.0:
            return worst
    return LOST


@kernel
def _forget(memory: FilterMemory, time: float) -> None:
    """Drop stored measurements that no step goes back to."""
    stored, first = memory.progress.stored, 0
    while first < stored and memory.stamps[first] <= time:
        first += 1
    if first > 0:
        for at in range(first, stored):
            _copy_stored(memory, at, at - first)
        memory.progress.stored = stored - first


@kernel
def _copy_stored(memory: FilterMemory, source: int, target: int) -> None:
    memory.stamps[target], memory.kinds[target] = memory.stamps[source], memory.kinds[source]
    memory.was_refused[target] = memory.was_refused[source]
    for i in range(memory.values.shape[1]):
        memory.values[target, i] = memory.values[source, i]


@kernel
def _keep(memory: FilterMemory, tick: int) -> None:
    place = tick % memory.kept_times.shape[0]
    memory.kept_means[place] = memory.means
    memory.kept_covariances[place] = memory.covariances
    memory.kept_weights[place] = memory.weights
    memory.kept_likelihoods[place] = memory.progress.log_likelihood
    memory.kept_scores.fused[place] = memory.scores.fused
    memory.kept_scores.refused[place] = memory.scores.refused
    memory.kept_scores.innovation[place] = memory.scores.innovation


@kernel
def _restore(memory: FilterMemory, tick: int) -> None:
    place = tick % memory.kept_times.shape[0]
    memory.means[:, :] = memory.kept_means[place]
    memory.covariances[:, :, :] = memory.kept_covariances[place]
    memory.weights[:] = memory.kept_weights[place]
    memory.progress.log_likelihood = memory.kept_likelihoods[place]
    memory.scores.fused[:] = memory.kept_scores.fused[place]
    memory.scores.refused[:] = memory.kept_scores.refused[place]
    memory.scores.innovation[:] = memory.kept_scores.innovation[place]
