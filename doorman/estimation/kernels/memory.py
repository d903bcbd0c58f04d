"""All that one filter's kernels read and write."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.numba_types.records import Record

Indices = NDArray[np.int64]


class Progress(Record):
    """How far a filter has come."""

    running: int  # whether there is a bank
    first: int  # oldest tick that is kept
    last: int  # newest tick
    stored: int  # how many measurements are stored
    broken: int  # how often a filter of the bank has lost its meaning in this step
    oldest_new: float  # stamp of the oldest measurement since the last step [s]
    longest_step: float  # [s]
    log_likelihood: float  # of all measurements


class Functions(NamedTuple):
    """Printed functions of one kind: of each hypothesis, shape (M, ...), or of each measurement under each, shape (K, M, ...)."""

    addresses: Indices
    rows: Indices  # how many each has
    equalities: Indices  # how many of them are equalities
    slope_ends: Indices  # where each row of a Jacobian ends among the nonzeros, beginning with 0
    slope_columns: Indices  # column of each nonzero


class Scores(NamedTuple):
    """Of each measurement, shape (K,); as they were at each kept tick, shape (T, K)."""

    fused: Array  # how often each was fused
    refused: Array  # and how often it was refused
    innovation: Array  # sum of its NIS


class FilterMemory(NamedTuple):
    """Rows of covariances, (n, w), are filled up with zeros to whole registers of four; so are gain and row.

    With M hypotheses, n states, m inputs, K measurements of at most r rows, T kept ticks and L stored measurements.
    """

    predictions: Functions
    holds: Functions
    switches: Functions
    outputs: Functions
    measurements: Functions
    noise_places: Indices  # count of nonzeros of each Q's lower half, then their rows and columns in turn
    gates: Array  # largest NIS of each measurement, shape (K,)
    lower: Array
    upper: Array  # ends of the states, shape (n,)
    parameters: Array

    means: Array  # means of the bank now, shape (M, n)
    covariances: Array  # shape (M, n, w)
    weights: Array  # probabilities of the hypotheses, shape (M,)
    allowed: Array  # 1 or 0, shape (M,)
    scores: Scores

    kept_times: Array  # the ring of ticks, shape (T,)
    kept_inputs: Array  # each holds from its tick to the next, shape (T, m)
    kept_allowed: Array
    kept_means: Array
    kept_covariances: Array
    kept_weights: Array
    kept_scores: Scores
    kept_likelihoods: Array  # shape (T,)

    progress: Progress
    stamps: Array  # stamps of the stored measurements, in their order, shape (L,)
    kinds: Indices
    values: Array  # shape (L, r)
    was_refused: Indices
    reading: Array  # reading of the measurement that arrives, shape (r,)
    coming: Array  # inputs from the next tick on, shape (m,)

    out: Array  # what printed functions write
    chances: Array  # probabilities of switching, shape (M, M)
    other_means: Array
    other_covariances: Array  # second bank, to mix into and to go back to
    logs: Array  # log-likelihoods, shape (M,)
    distances: Array  # NIS, shape (M,)
    innovations: Array
    variances: Array
    before: Array  # mean before the rows of one measurement, shape (n,)
    row: Array  # P hᵀ, shape (w,)
    gain: Array
    half: Array
    half_across: Array  # scratch, shape (n, w)
    mean: Array  # mean of all hypotheses together, shape (n,)
    covariance: Array
    output: Array
    output_variance: Array
