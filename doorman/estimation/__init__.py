"""Filters from expressions: a bank of extended Kalman filters for any model, any sensors and any hypotheses. Knows no door."""

from __future__ import annotations

from typing import TYPE_CHECKING

from doorman.lazy_names import lazy_names

if TYPE_CHECKING:  # the types of the names below; no layer hides an import here
    from doorman.estimation.estimate import FilterEstimate, MeasurementScore
    from doorman.estimation.filter import Filter
    from doorman.estimation.hypothesis import Hypothesis, Row
    from doorman.estimation.measurement import Measurement
    from doorman.estimation.model import ProcessModel
    from doorman.estimation.output import Output
    from doorman.estimation.status import Status

__all__ = [
    "Filter", "FilterEstimate", "Hypothesis", "Measurement", "MeasurementScore", "Output", "ProcessModel", "Row", "Status",
]  # fmt: skip

_MODULES = {
    "Filter": "filter",
    "FilterEstimate": "estimate",
    "Hypothesis": "hypothesis",
    "Measurement": "measurement",
    "MeasurementScore": "estimate",
    "Output": "output",
    "ProcessModel": "model",
    "Row": "hypothesis",
    "Status": "status",
}

if not TYPE_CHECKING:  # a type checker would take any name for granted
    __getattr__, __dir__ = lazy_names(__name__, _MODULES)
