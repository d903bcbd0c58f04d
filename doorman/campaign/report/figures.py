"""Figures of a campaign: rates with their intervals, quantiles, and every failure, as data for the report's pages."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from doorman.campaign.results import SUMMARY, Row

TORQUE = "torque"
"""Name of the estimate of the hinge's whole resistance."""
_ESTIMATES = f"{SUMMARY}estimates."
TORQUE_SHARE, TORQUE_ERROR = 0.25, 0.15
"""An estimated torque is good within this share of the true one, or within so many N m."""


@dataclass(frozen=True)
class Metric:
    """A number of every run that is worth its quantiles."""

    column: str
    words: str
    unit: str
    limits: tuple[float, float] | None = None  # of its histogram; None: it has none


_FREE = (-math.inf, math.inf)
METRICS = (
    Metric("final_error_deg", "final angle minus target", "deg", (-5.0, 5.0)),
    Metric("final_error_m", "final opening minus target", "m", (-0.05, 0.05)),
    Metric(f"{SUMMARY}hover_to_goal_s", "from hover to goal", "s", _FREE),
    Metric(f"{SUMMARY}contact_fraction_after_1s", "in contact from 1 s after the first touch", "", _FREE),
    Metric(f"{SUMMARY}door_angle_estimate_error_deg_max", "largest error of the estimated angle", "deg", (0.0, 5.0)),
    Metric("torque_error_n_m", "estimated minus true resistance at the end", "N m", (-1.0, 1.0)),
    Metric(f"{SUMMARY}contact_fraction", "in contact from the first touch", ""),
    Metric(f"{SUMMARY}max_push_force_n", "largest push of the tip", "N"),
    Metric(f"{SUMMARY}time_to_open_s", "from the first touch to the goal", "s"),
    Metric(f"{SUMMARY}duration_s", "whole flight", "s"),
    Metric(f"{SUMMARY}min_clearance_m", "smallest clearance", "m"),
    Metric(f"{SUMMARY}planned_normal_force_n_min", "least planned normal force", "N"),
    Metric(f"{SUMMARY}planner_ms.median", "planner, median", "ms"),
)


_QUANTILE = 1.959963984540054
"""Quantile of the normal distribution for 95 %."""
LOW_FRICTION = 0.5
"""Doors with less true friction are also reported separately: a push finds them the hardest to stop [N m]."""


def figures(rows: Sequence[Row], low_friction: float) -> dict[str, Any]:
    """Everything that the report says, for JSON."""
    slippery = [row for row in rows if row["friction"] is not None and row["friction"] < low_friction]
    return {
        "all": _rate(rows),
        "low_friction": {"below_n_m": low_friction, **_rate(slippery)},
        "collisions": sum(bool(row.get(f"{SUMMARY}collisions")) for row in rows),
        "errors": sum(row["error"] is not None for row in rows),
        "safe_failures": sum(row["safe"] and not row["success"] for row in rows),
        "wrong_reasons": sum(row.get("told_truly") is False for row in rows),
        "outcomes": dict(Counter(str(row["outcome"] or "none") for row in rows).most_common()),
        "reasons": dict(Counter(row["reason"] for row in rows if not row["success"]).most_common()),
        "quantiles": {metric.column: quantiles for metric in METRICS if (quantiles := _quantiles(rows, metric.column))},
        "estimates": estimates(rows),
        "failures": [failure(row) for row in rows if not row["success"]],
    }


def failure(row: Row) -> dict[str, Any]:
    """What the report says of a failed run, by name."""
    named = {name: row[name] for name in ("run", "seed", "outcome", "reason", "final_error_deg", "command")}
    named["final_error_m"] = row.get("final_error_m")
    causes = row.get(f"{SUMMARY}true_causes")
    return named | {"true_causes": json.loads(causes) if causes else [], "told_truly": row.get("told_truly")}


def numbers(rows: Sequence[Row], column: str) -> np.ndarray:
    """Finite values of a column."""
    values = [float(row[column]) for row in rows if isinstance(row.get(column), (int, float))]
    return np.array([value for value in values if math.isfinite(value)])


def estimates(rows: Sequence[Row]) -> dict[str, Any]:
    """How often a true value lies within two standard deviations of its estimate, by name of the estimated quantity."""
    found: dict[str, Any] = {}
    for name in estimated(rows):
        value, true, deviation = estimate_columns(rows, name).T
        errors = np.abs(value - true)
        found[name] = {
            "runs": len(errors),
            "median_error": float(np.median(errors)),
            "within_two_deviations": float(np.mean(errors <= 2.0 * deviation)),
        }
        if name == TORQUE:
            found[name]["good"] = float(np.mean(errors <= np.maximum(TORQUE_SHARE * np.abs(true), TORQUE_ERROR)))
    return found


def estimated(rows: Sequence[Row]) -> list[str]:
    """Names of the quantities that the runs have estimated."""
    names = {name: None for row in rows for name in row if name.startswith(_ESTIMATES) and name.endswith(".value")}
    return [name.removeprefix(_ESTIMATES).removesuffix(".value") for name in names]


def estimate_columns(rows: Sequence[Row], name: str) -> np.ndarray:
    """Estimated value, true value and standard deviation of every run that has them."""
    columns = [f"{_ESTIMATES}{name}.{part}" for part in ("value", "true", "deviation")]
    known = [row for row in rows if all(isinstance(row.get(column), (int, float)) for column in columns)]
    return np.array([[row[column] for column in columns] for row in known]).reshape(-1, 3)


def _rate(rows: Sequence[Row]) -> dict[str, Any]:
    successes = sum(row["success"] for row in rows)
    lower, upper = wilson_interval(successes, len(rows))
    rate = successes / len(rows) if rows else None
    return {"runs": len(rows), "successes": successes, "rate": rate, "interval_95": [lower, upper]}


def _quantiles(rows: Sequence[Row], column: str) -> dict[str, float]:
    values = numbers(rows, column)
    if not len(values):
        return {}
    shares = {"min": 0.0, "p05": 0.05, "median": 0.5, "p95": 0.95, "max": 1.0}
    return {name: float(np.quantile(values, share)) for name, share in shares.items()}


def wilson_interval(successes: int, runs: int) -> tuple[float, float]:
    """Wilson's 95 % confidence interval of a success rate p: (p + z²/2n ± z √(p(1−p)/n + z²/4n²)) / (1 + z²/n)."""
    if runs == 0:
        return 0.0, 1.0
    share, z2 = successes / runs, _QUANTILE**2 / runs
    center = share + z2 / 2
    half = math.sqrt(z2 * (share * (1.0 - share) + z2 / 4))
    return max((center - half) / (1.0 + z2), 0.0), min((center + half) / (1.0 + z2), 1.0)
