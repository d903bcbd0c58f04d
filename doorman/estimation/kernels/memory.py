"""All that one filter's kernels read and write, and the places in it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array

Indices = NDArray[np.int64]

PREDICT, HOLD, SWITCH, OUTPUT, MEASURE = range(5)
"""Kinds of printed functions. Of M hypotheses, function kind · M + j is that of the j-th; (4 + k) M + j reads measurement k."""
FIRST, LAST, STARTED, STORED, BROKEN, PLACES = range(6)
"""Oldest and newest tick that is kept, whether there is a bank, how many measurements are stored, and how often a filter of the
bank has lost its meaning in this step."""
OLDEST_NEW, LONGEST_STEP, CLOCKS = range(3)
"""Stamp of the oldest measurement since the last step, and the longest step [s]."""
LOG_LIKELIHOOD, SCORES = range(2)
FUSED, REFUSED, INNOVATION, SCORES_OF_EACH = range(4)
"""Places in the scores: of all, then for each measurement how often it was fused and refused, and the sum of its NIS."""


class FilterMemory(NamedTuple):
    """Rows of covariances, (n, w), are filled up with zeros to whole registers of four; so are gain and row.

    With M hypotheses, n states, m inputs, K measurements of at most r rows, T kept ticks and L stored measurements.
    """

    addresses: Indices
    """Addresses of the printed functions, shape (4 M + K M,)."""
    rows: Indices
    """Rows of each function, and how many of them are equalities, shape (4 M + K M, 2)."""
    slope_ends: Indices
    """Where each row of a Jacobian ends among the nonzeros, beginning with 0."""
    slope_columns: Indices
    """Column of each nonzero."""
    noise_places: Indices
    """Count of nonzeros of each Q's lower half, then their rows and columns in turn."""
    gates: Array
    """Largest NIS of each measurement, shape (K,)."""
    lower: Array
    upper: Array
    """Ends of the states, shape (n,)."""
    parameters: Array

    means: Array
    """Means of the bank now, shape (M, n)."""
    covariances: Array
    """Shape (M, n, w)."""
    weights: Array
    """Probabilities of the hypotheses, shape (M,)."""
    allowed: Array
    """1 or 0, shape (M,)."""
    scores: Array

    kept_times: Array
    """The ring of ticks, shape (T,)."""
    kept_inputs: Array
    """Each holds from its tick to the next, shape (T, m)."""
    kept_allowed: Array
    kept_means: Array
    kept_covariances: Array
    kept_weights: Array
    kept_scores: Array

    places: Indices
    clocks: Array
    stamps: Array
    """Stamps of the stored measurements, in their order, shape (L,)."""
    kinds: Indices
    values: Array
    """Shape (L, r)."""
    was_refused: Indices
    reading: Array
    """Reading of the measurement that arrives, shape (r,)."""
    coming: Array
    """Inputs from the next tick on, shape (m,)."""

    out: Array
    """What printed functions write."""
    chances: Array
    """Probabilities of switching, shape (M, M)."""
    other_means: Array
    other_covariances: Array
    """Second bank, to mix into and to go back to."""
    logs: Array
    """Log-likelihoods, shape (M,)."""
    distances: Array
    """NIS, shape (M,)."""
    innovations: Array
    variances: Array
    before: Array
    """Mean before the rows of one measurement, shape (n,)."""
    row: Array
    """P hᵀ, shape (w,)."""
    gain: Array
    half: Array
    half_across: Array
    """Scratch, shape (n, w)."""
    mean: Array
    """Mean of all hypotheses together, shape (n,)."""
    covariance: Array
    output: Array
    output_variance: Array
