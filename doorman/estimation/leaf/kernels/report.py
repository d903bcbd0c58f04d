"""What a filter at the leaf tells, in the order of its numbers; see `LeafMotion` and `leaf_filter`."""

from __future__ import annotations

from typing import Annotated, NamedTuple, Self

from doorman.arrays import Array
from doorman.estimation.estimate import FilterEstimate
from doorman.numba_types.records import Record, Vector3


class LeafState(Record):
    """State of the filter, or its deviations."""

    position: Vector3
    velocity: Vector3
    wind: Vector3
    wind_turn: float
    gust: float
    lift: float
    joint: float
    joint_rate: float
    resistance: float
    log_inertia: float
    face: float
    reach: float
    friction: Annotated[Array, 2]


class LeafOutputs(Record):
    """Its outputs."""

    normal_force: float
    wind: Vector3
    slip: Annotated[Array, 2]
    gains: Vector3
    borne: float


class LeafReport(NamedTuple):
    """Views of an estimate."""

    state: LeafState
    deviations: LeafState
    chances: Array
    """Probabilities of the hypotheses."""
    outputs: LeafOutputs

    @classmethod
    def of(cls, estimate: FilterEstimate) -> Self:
        """Views of an estimate of the filter at the leaf."""
        report, n, count = estimate.report, estimate.mean.size, len(estimate.hypotheses)
        values = 2 * n + count
        outputs = report[values : values + len(estimate.output_names)]
        return cls(
            LeafState.over(report[:n]),
            LeafState.over(report[n : 2 * n]),
            report[2 * n : values],
            LeafOutputs.over(outputs),
        )
