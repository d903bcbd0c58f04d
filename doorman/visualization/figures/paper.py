"""The states of a flight in the layout of the paper's Fig. 4."""

from __future__ import annotations

import numpy as np

from doorman.exceptions import RecordingError
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.figures.states import LEAST, LOOK_AHEAD
from doorman.visualization.style import BLACK, GREEN, RED, Figure, widen

_OF_BODY_AND_DOOR = (("φ", 0), ("θ", 1), ("ψ", 2), ("α", 3))
"""Symbols, and places in the state; the rate of the door is not an angle, and not in the paper's figure."""
_FIRST_OF_ARM = 5


def paper_figure(recording: Recording, model: Model) -> Figure:
    """History of the states: φ, θ, ψ and α on the left, the arm's angles on the right, in degrees.

    Measured is black, predicted by the planner dashed orange, desired green.

    Args:
        recording: With topics `estimate` and `plan`.
        model: Model of the scenario that was flown.

    Returns:
        The figure; `save` writes it.

    Raises:
        RecordingError: if the recording has no estimated state or no plan, or the plans have other states than the paper's.
    """
    estimate, plan = recording["estimate"], recording["plan"]
    if plan["states"].shape[2] != model.nx:
        raise RecordingError(
            "the plans have other states than the paper's", field="planner.model", allowed="quasi_static"
        )
    arm = [(f"$\\eta_{{{joint + 1}}}$", _FIRST_OF_ARM + joint) for joint in range(model.n_arm)]
    columns = (_OF_BODY_AND_DOOR, arm)
    rows = max(len(column) for column in columns)
    figure = Figure(figsize=(9.0, 1.7 * rows + 0.4), layout="constrained")
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False)
    step = model.scenario.planner.time_step
    ahead = min(round(LOOK_AHEAD / step), plan["states"].shape[1] - 1)
    for column, states in enumerate(columns):
        for row, axes in enumerate(panels[:, column]):
            if row >= len(states):
                axes.set_axis_off()
                continue
            symbol, place = states[row]
            axes.plot(estimate.time, np.degrees(estimate["state"][:, place]), color=BLACK, label="measured")
            predicted = np.degrees(plan["states"][:, ahead, place])
            axes.plot(plan.time + ahead * step, predicted, color=RED, linestyle="--", label="predicted")
            axes.axhline(float(np.degrees(model.goal_state[place])), color=GREEN, label="desired", zorder=1.5)
            axes.set_ylabel(f"{symbol} [deg]")
            widen(axes, LEAST)
        panels[len(states) - 1, column].set_xlabel("time [s]")
        panels[len(states) - 1, column].tick_params(labelbottom=True)
    panels[0, 0].set_xlim(float(estimate.time[0]), float(estimate.time[-1]))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=9)
    return figure
