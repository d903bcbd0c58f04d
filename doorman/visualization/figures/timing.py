"""Figure of the planner's time: how often each time was taken, and how many plans came after their deadline."""

from __future__ import annotations

import numpy as np

from doorman.model import Model
from doorman.recording import Recording
from doorman.summary import cold_plans
from doorman.visualization.style import BLACK, BLUE, ORANGE, RED, Figure, FuncFormatter, flight_name, not_recorded

_BINS_PER_DECADE = 20


def planner_time_figure(recording: Recording, model: Model) -> Figure:
    """Histogram of the time for one plan, with its quantiles and the planner's period as deadline.

    A bar counts the plans that took so long. Cold plans, which begin without one before, are drawn in a colour of their own: no
    deadline holds for them, and the quantiles are those of the warm ones, as `planner_ms` in `summary.json` has them.

    Args:
        recording: What was flown; says so if there are no plans.
        model: Model of the scenario that was flown.

    Returns:
        The figure; `save` writes it.
    """
    figure = Figure(figsize=(7.0, 3.8), layout="constrained")
    axes = figure.subplots()
    axes.set_xlabel("time for one plan [ms]")
    axes.set_ylabel("plans")
    figure.suptitle(f"Planner's time: {flight_name(recording)}", fontsize=11)
    if "plan" not in recording:
        not_recorded(axes)
        return figure
    plan, deadline = recording["plan"], 1e3 / model.scenario.planner.rate
    milliseconds = np.maximum(1e3 * plan["solve_time"], 1e-3)
    cold = cold_plans(plan) if "cold" in plan else np.zeros(len(plan.time), dtype=bool)
    low, high = np.log10(min(milliseconds.min(), deadline)), np.log10(max(milliseconds.max(), deadline))
    first, last = np.floor(low * 2) / 2, np.ceil(high * 2 + 0.2) / 2
    edges = np.logspace(first, last, int((last - first) * _BINS_PER_DECADE) + 1).tolist()
    shares = {f"{words}: {len(some)}" + (f", at most {some.max():.2f} ms" if len(some) else ""): some
              for words, some in (("warm", milliseconds[~cold]), ("cold", milliseconds[cold]))}  # fmt: skip
    warm = milliseconds[~cold]
    axes.hist(list(shares.values()), edges, stacked=True, color=[BLUE, ORANGE], label=list(shares))
    if len(warm):
        for share, style in ((50, ":"), (99, "-.")):
            value = float(np.percentile(warm, share))
            axes.axvline(value, color=BLACK, linestyle=style, linewidth=1.2, label=f"{share} %: {value:.2f} ms")
    late = int(plan["deadline_missed"].sum())
    axes.axvline(deadline, color=RED, linestyle="--", linewidth=1.6, label=f"deadline {deadline:g} ms, late: {late}")
    axes.axvspan(deadline, edges[-1], color=RED, alpha=0.1, linewidth=0)
    axes.set_xscale("log")
    axes.set_yscale("symlog", linthresh=1.0)
    axes.set_xlim(edges[0], edges[-1])
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8, loc="best")
    return figure
