"""Histograms of a campaign: final error, time, contact and errors of estimates; successes and failures in two colours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from doorman.campaign.judgement import TOLERANCE
from doorman.campaign.report.figures import METRICS, TORQUE, Metric, estimate_columns, estimated, numbers
from doorman.campaign.results import Row
from doorman.visualization.style import BLUE, CYCLE, RED, Axes, Figure, MaxNLocator

_BINS = 30
_WIDEST = 4.0
"""Errors beyond so many deviations are drawn there."""


def histograms(rows: Sequence[Row], name: str) -> Figure:
    figure = Figure(figsize=(13.0, 6.6), layout="constrained")
    panels = figure.subplots(2, 3).ravel()
    good, bad = [[row for row in rows if row["success"] is success] for success in (True, False)]
    slides = len(numbers(rows, "final_error_m")) > 0
    unused = "final_error_deg" if slides else "final_error_m"
    drawn = (metric for metric in METRICS if metric.limits and metric.column != unused)
    for axes, metric in zip(panels, drawn, strict=False):
        _draw(axes, metric, good, bad)
    _draw_deviations(panels[-1], rows)
    within, words = (TOLERANCE["m"], "within 1.4 cm") if slides else (TOLERANCE["deg"], "within 2°")
    panels[0].axvspan(-within, within, color="0.92", zorder=0, label=words)
    panels[0].legend(fontsize=8)
    figure.suptitle(f"{name}: {len(good)} of {len(rows)} runs succeeded")
    return figure


def _draw(axes: Axes, metric: Metric, good: Sequence[Row], bad: Sequence[Row]) -> None:
    values = [numbers(rows, metric.column) for rows in (good, bad)]
    series = [np.clip(some, *(metric.limits or (None, None))) for some in values]
    together = np.concatenate(series)
    unit = f" [{metric.unit}]" if metric.unit else ""
    beyond = "\n(outermost bins: and beyond)" if (np.concatenate(values) != together).any() else ""
    axes.set_xlabel(metric.words + unit + beyond)
    axes.set_ylabel("runs")
    if not len(together):
        axes.text(0.5, 0.5, "no run has it", ha="center", va="center", transform=axes.transAxes)
        return
    edges = np.histogram_bin_edges(together, bins=_BINS)
    axes.hist(series, bins=edges.tolist(), stacked=True, color=[BLUE, RED], label=["success", "failure"])
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _draw_deviations(axes: Axes, rows: Sequence[Row]) -> None:
    """Errors of the estimated parameters in their own standard deviations: honest ones are within two on 95 % of doors."""
    axes.axvspan(-2.0, 2.0, color="0.92", zorder=0)
    for name, color in zip((name for name in estimated(rows) if name != TORQUE), CYCLE, strict=False):
        value, true, deviation = estimate_columns(rows, name).T
        errors = np.clip((value - true) / np.maximum(deviation, 1e-12), -_WIDEST, _WIDEST)
        axes.hist(errors, bins=np.linspace(-_WIDEST, _WIDEST, 25).tolist(), histtype="step", color=color, label=name)
    axes.set_xlabel("error of an estimate over its standard deviation")
    axes.set_ylabel("runs")
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(fontsize=8)
