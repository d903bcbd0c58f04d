"""A filter's memory: its functions compiled, their sparsity in tables, and room for its ticks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from doorman.arrays import Array
from doorman.estimation.kernels.memory import CLOCKS, PLACES, SCORES, SCORES_OF_EACH, FilterMemory
from doorman.estimation.kernels.printed_functions import address_of
from doorman.estimation.measurement import Measurement
from doorman.estimation.model import ProcessModel
from doorman.estimation.printed.functions import Function, padded
from doorman.ocp.kernels.printed.loading import load


def memory_of(
    text: str, functions: Sequence[Function], model: ProcessModel, measurements: Sequence[Measurement],
    hypotheses: int, outputs: int, parameters: Array, ticks: int,
) -> FilterMemory:  # fmt: skip
    """Fresh memory."""
    module = load(text)
    n, m, kinds = model.size, int(model.inputs.numel()), len(measurements)
    w = n + -n % 4
    read = functions[4 * hypotheses :]
    widest = max([each.rows for each in functions], default=1)
    places = [each.places() for each in functions]
    stored = ticks * max(kinds, 1)
    zeros = np.zeros
    return FilterMemory(
        addresses=np.array(
            [address_of(getattr(module, each.name)) if each.size else 0 for each in functions], dtype=np.int64
        ),
        rows=np.array([(each.rows, each.equalities) for each in functions], dtype=np.int64),
        slope_ends=padded([ends for ends, _ in places]), slope_columns=padded([columns for _, columns in places]),
        noise_places=padded([each.noise_places() for each in functions if each.noise is not None]),
        gates=np.array([each.gate**2 for each in measurements]), lower=np.array(model.lower), upper=np.array(model.upper),
        parameters=parameters,
        means=zeros((hypotheses, n)), covariances=zeros((hypotheses, n, w)), weights=zeros(hypotheses),
        allowed=np.ones(hypotheses), scores=zeros(SCORES + SCORES_OF_EACH * kinds),
        kept_times=zeros(ticks), kept_inputs=zeros((ticks, m)), kept_allowed=zeros((ticks, hypotheses)),
        kept_means=zeros((ticks, hypotheses, n)), kept_covariances=zeros((ticks, hypotheses, n, w)),
        kept_weights=zeros((ticks, hypotheses)), kept_scores=zeros((ticks, SCORES + SCORES_OF_EACH * kinds)),
        places=zeros(PLACES, dtype=np.int64), clocks=zeros(CLOCKS), stamps=zeros(stored),
        kinds=zeros(stored, dtype=np.int64), values=zeros((stored, max([each.rows for each in read], default=1))),
        was_refused=zeros(stored, dtype=np.int64), reading=zeros(max([each.rows for each in read], default=1)),
        coming=zeros(m),
        out=zeros(max(each.size for each in functions)), chances=zeros((hypotheses, hypotheses)),
        other_means=zeros((hypotheses, n)), other_covariances=zeros((hypotheses, n, w)), logs=zeros(hypotheses),
        distances=zeros(hypotheses), innovations=zeros(widest), variances=zeros(widest), before=zeros(n), row=zeros(w),
        gain=zeros(w), half=zeros((n, w)), half_across=zeros((n, w)), mean=zeros(n), covariance=zeros((n, w)),
        output=zeros(outputs), output_variance=zeros(outputs),
    )  # fmt: skip
