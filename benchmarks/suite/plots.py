"""Figures as plots, PNG and SVG, in colours that the colour-blind can tell apart."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np

from suite.peers import ENTRIES
from suite.statistics import Row, by, column, milliseconds
from suite.tables import per_node

STYLES = {
    "doorman": ("#0072B2", "o", "-"), "doorman_timed": ("#56B4E9", "o", "--"), "ipopt": ("#000000", "s", "-"),
    "fatrop": ("#D55E00", "^", "-"), "hpipm": ("#009E73", "v", "-"), "hpipm_tuned": ("#009E73", "D", "--"),
    "hpipm_exact": ("#009E73", "x", ":"), "csqp": ("#CC79A7", "P", "-"), "pycddp": ("#E69F00", "*", "-"),
    "acados_door": ("#0072B2", "X", ":"),
}  # fmt: skip
"""Colour (Okabe and Ito), marker and line of every solver: none is told by its colour alone."""


TOTALS = ("whole call", "all kernels in one call")
"""Entries of the phases that are sums of others."""


def save(figure: Any, folder: Path, name: str) -> None:
    """Write both formats."""
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"{name}.png", dpi=150)
    figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    plt.close(figure)


def cold(rows: Sequence[Row], time_step: float = 0.02) -> Any:
    """Time of a cold plan along the closed loop, by solver."""
    figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
    for name, own in by(rows, "solver").items():
        solved = [row for row in own if row["solved"]]
        _line(axes, name, time_step * column(solved, "state"), milliseconds(solved))
        failed = [row for row in own if not row["solved"] and "seconds" in row]
        if failed:
            axes.plot(
                time_step * column(failed, "state"), milliseconds(failed), linestyle="none", marker="X", markersize=10,
                color=STYLES[name][0], markeredgecolor="white", label=f"{ENTRIES[name].label}: not solved",
            )  # fmt: skip
    axes.set(yscale="log", xlabel="time along the closed loop [s]", ylabel="cold plan [ms]")
    _finish(figure, axes)
    return figure


def doors(rows: Sequence[Row]) -> Any:
    """Cold plans for doors drawn at random: every state, door by door."""
    figure, axes = plt.subplots(figsize=(8, 4.5), layout="constrained")
    tasks = list(by(rows, "task"))
    names = list(by(rows, "solver"))
    for k, name in enumerate(names):
        own = [row for row in rows if row["solver"] == name and row["solved"]]
        places = [tasks.index(row["task"]) + 0.8 * ((k + 0.5) / len(names) - 0.5) for row in own]
        color, marker, _ = STYLES[name]
        axes.plot(places, milliseconds(own), marker, color=color, markersize=4, label=ENTRIES[name].label)
    axes.set_xticks(range(len(tasks)), tasks)
    for k in range(1, len(tasks)):
        axes.axvline(k - 0.5, color="0.85", linewidth=0.8)
    axes.set(yscale="log", ylabel="cold plan [ms]")
    _finish(figure, axes)
    return figure


def replans(rows: Sequence[Row]) -> Any:
    """Times of single iterations: share of calls that take no longer."""
    figure, axes = plt.subplots(figsize=(8, 4.0), layout="constrained")
    for name, own in by([row for row in rows if "seconds" in row], "solver").items():
        _shares(axes, name, milliseconds([row for row in own if not row["interrupted"]]))
    axes.set(xscale="log", xlabel="one iteration [ms]", ylabel="share of calls that take no longer")
    _finish(figure, axes)
    return figure


def disturbed(rows: Sequence[Row]) -> Any:
    """Suboptimality and violation of single iterations under noise."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), sharey=True, layout="constrained")
    for name, own in by([row for row in rows if "seconds" in row and row["usable"]], "solver").items():
        _shares(left, name, np.maximum(np.abs(column(own, "gap")), 1e-12))
        _shares(right, name, np.maximum(np.maximum(column(own, "violation"), column(own, "defect")), 1e-12))
    left.set(xscale="log", xlabel="relative distance of the cost from the optimum's", ylabel="share of plans")
    right.set(xscale="log", xlabel="violation of constraints [m] or dynamics (1e-12: none)")
    for axes in (left, right):
        axes.grid(alpha=0.3)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize="small", frameon=False)
    return figure


def horizons(rows: Sequence[Row]) -> Any:
    """Cold plans over the horizon's length: in all, and per node and iteration."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.6), layout="constrained")
    for name, own in by(rows, "solver").items():
        groups = by([row for row in own if row["solved"]], "horizon")
        sizes = np.array(list(groups), dtype=float)
        _line(left, name, sizes, np.array([np.median(milliseconds(group)) for group in groups.values()]))
        _line(right, name, sizes, np.array([np.median(per_node(group)) for group in groups.values()]))
    left.set(xscale="log", yscale="log", xlabel="N, steps of 0.02 s", ylabel="cold plan, median [ms]")
    right.set(xscale="log", yscale="log", xlabel="N, steps of 0.02 s", ylabel="per node and iteration, median [µs]")
    for axes in (left, right):
        axes.set_xticks(
            sorted({row["horizon"] for row in rows}), labels=[str(n) for n in sorted({row["horizon"] for row in rows})]
        )
        axes.minorticks_off()
        axes.grid(alpha=0.3)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize="small", frameon=False)
    return figure


def arms(rows: Sequence[Row]) -> Any:
    """Cold plans over the number of joints."""
    figure, axes = plt.subplots(figsize=(8, 4.2), layout="constrained")
    for name, own in by(rows, "solver").items():
        groups = by([row for row in own if row["solved"]], "joints")
        _line(
            axes,
            name,
            np.array(list(groups), dtype=float),
            np.array([np.median(milliseconds(g)) for g in groups.values()]),
        )
    axes.set(yscale="log", xlabel="joints of the arm", ylabel="cold plan, median [ms]")
    _finish(figure, axes)
    return figure


def phases(seconds: dict[str, float]) -> Any:
    """Parts of a replan as a bar."""
    parts = {name: 1e6 * value for name, value in seconds.items() if name not in TOTALS}
    colors = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442"]
    hatches = ["", "//", "", "..", "", "\\\\", ""]
    figure, axes = plt.subplots(figsize=(8, 2.2), layout="constrained")
    left = 0.0
    for (name, value), color, hatch in zip(parts.items(), colors, hatches, strict=False):
        axes.barh(0, value, left=left, color=color, hatch=hatch, edgecolor="white", label=f"{name} {value:.1f}")
        left += value
    axes.set(xlabel="one replan [µs]", yticks=[], xlim=(0.0, 1.02 * left))
    figure.legend(loc="outside lower center", ncols=4, fontsize="small", frameon=False)
    return figure


def _line(axes: Any, name: str, x: Any, y: Any) -> None:
    color, marker, line = STYLES[name]
    axes.plot(x, y, color=color, marker=marker, linestyle=line, markersize=4, linewidth=1.2, label=ENTRIES[name].label)


def _shares(axes: Any, name: str, values: Any) -> None:
    color, marker, line = STYLES[name]
    ordered = np.sort(values)
    shares = np.arange(1, len(ordered) + 1) / max(len(ordered), 1)
    every = max(len(ordered) // 8, 1)
    axes.plot(
        ordered, shares, color=color, linestyle=line, linewidth=1.4, marker=marker, markersize=4, markevery=every,
        label=ENTRIES[name].label,
    )  # fmt: skip


def _finish(figure: Any, axes: Any) -> None:
    axes.grid(alpha=0.3, axis="y")
    figure.legend(loc="outside lower center", ncols=3, fontsize="small", frameon=False)
