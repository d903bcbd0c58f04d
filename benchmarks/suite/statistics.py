"""Medians, tails and ratios of what the workloads return."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Row = dict[str, Any]


def by(rows: Iterable[Row], *keys: str) -> dict[Any, list[Row]]:
    """Rows by the value of a key, or by the values of several, in the order in which they first occur."""
    groups: dict[Any, list[Row]] = {}
    for row in rows:
        value = tuple(row[key] for key in keys) if len(keys) > 1 else row[keys[0]]
        groups.setdefault(value, []).append(row)
    return groups


def column(rows: Iterable[Row], key: str) -> NDArray[np.float64]:
    """Values of a key, where there is one."""
    return np.array([row[key] for row in rows if row.get(key) is not None], dtype=np.float64)


def milliseconds(rows: Iterable[Row]) -> NDArray[np.float64]:
    """Times [ms]."""
    return 1e3 * column(rows, "seconds")


def ratios(rows: Sequence[Row], solver: str, keys: Sequence[str], ours: str = "doorman") -> NDArray[np.float64]:
    """How many times longer a solver takes than doorman, case by case, where both solve the case.

    Args:
        rows: With `solver`, `seconds`, `solved` and the keys that tell one case from another.
        solver: The rival.
        keys: Of a case.
        ours: Name of doorman's rows.
    """
    times: dict[str, dict[Any, float]] = {solver: {}, ours: {}}
    for row in rows:
        if row["solver"] in times and row.get("solved", True) and "seconds" in row:
            times[row["solver"]][tuple(row[key] for key in keys)] = row["seconds"]
    shared = times[solver].keys() & times[ours].keys()
    return np.array([times[solver][case] / times[ours][case] for case in sorted(shared)])


def quantiles(values: NDArray[np.float64]) -> dict[str, float]:
    """Median, tails and the largest of some values."""
    levels = {"median": 0.5, "p99": 0.99, "p99.9": 0.999, "max": 1.0}
    return {name: float(np.quantile(values, level)) for name, level in levels.items()}
