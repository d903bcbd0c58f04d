"""A filter's memory: its functions compiled, their sparsity in tables, and room for its ticks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.estimation.kernels.memory import FilterMemory, Functions, Progress, Scores
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
    predictions, holds, switches, output_functions = (
        _of_kind(module, functions[kind * hypotheses : (kind + 1) * hypotheses], (hypotheses,)) for kind in range(4)
    )
    read = functions[4 * hypotheses :]
    widest = max([each.rows for each in functions], default=1)
    stored = ticks * max(kinds, 1)
    zeros = np.zeros
    return FilterMemory(
        predictions=predictions, holds=holds, switches=switches, outputs=output_functions,
        measurements=_of_kind(module, read, (kinds, hypotheses)),
        noise_places=padded([each.noise_places() for each in functions if each.noise is not None]),
        gates=np.array([each.gate**2 for each in measurements]), lower=np.array(model.lower), upper=np.array(model.upper),
        parameters=parameters,
        means=zeros((hypotheses, n)), covariances=zeros((hypotheses, n, w)), weights=zeros(hypotheses),
        allowed=np.ones(hypotheses), scores=_scores(kinds),
        kept_times=zeros(ticks), kept_inputs=zeros((ticks, m)), kept_allowed=zeros((ticks, hypotheses)),
        kept_means=zeros((ticks, hypotheses, n)), kept_covariances=zeros((ticks, hypotheses, n, w)),
        kept_weights=zeros((ticks, hypotheses)), kept_scores=_scores(ticks, kinds), kept_likelihoods=zeros(ticks),
        progress=Progress(), stamps=zeros(stored),
        kinds=zeros(stored, dtype=np.int64), values=zeros((stored, max([each.rows for each in read], default=1))),
        was_refused=zeros(stored, dtype=np.int64), reading=zeros(max([each.rows for each in read], default=1)),
        coming=zeros(m),
        out=zeros(max(each.size for each in functions)), chances=zeros((hypotheses, hypotheses)),
        other_means=zeros((hypotheses, n)), other_covariances=zeros((hypotheses, n, w)), logs=zeros(hypotheses),
        distances=zeros(hypotheses), innovations=zeros(widest), variances=zeros(widest), before=zeros(n), row=zeros(w),
        gain=zeros(w), half=zeros((n, w)), half_across=zeros((n, w)), mean=zeros(n), covariance=zeros((n, w)),
        output=zeros(outputs), output_variance=zeros(outputs),
    )  # fmt: skip


def _of_kind(module: Any, functions: Sequence[Function], shape: tuple[int, ...]) -> Functions:
    """Functions of one kind, compiled."""
    places = [each.places() for each in functions]
    addresses = [address_of(getattr(module, each.name)) if each.size else 0 for each in functions]
    numbers = addresses, [each.rows for each in functions], [each.equalities for each in functions]
    tables = padded([ends for ends, _ in places]), padded([columns for _, columns in places])
    return Functions(
        *(np.array(each, dtype=np.int64).reshape(shape) for each in numbers),
        *(table.reshape(*shape, table.shape[1]) for table in tables),
    )


def _scores(*shape: int) -> Scores:
    return Scores(np.zeros(shape), np.zeros(shape), np.zeros(shape))
