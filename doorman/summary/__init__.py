"""Summary of a run: the figures of `summary.json`, from the true states where a simulator recorded them."""

from doorman.summary.figures import cold_plans, summarize
from doorman.summary.measured import has_measured_leaf, sentence_by_the_leaf
from doorman.summary.outcome import (
    COMPLETED,
    FLOWN,
    GIVEN_UP,
    GOAL_MISSED,
    OPEN_TOLERANCE,
    TOUCHED,
    time_to_open,
    verdict,
)

__all__ = [
    "COMPLETED",
    "FLOWN",
    "GIVEN_UP",
    "GOAL_MISSED",
    "OPEN_TOLERANCE",
    "TOUCHED",
    "cold_plans",
    "has_measured_leaf",
    "summarize",
    "time_to_open",
    "sentence_by_the_leaf",
    "verdict",
]
