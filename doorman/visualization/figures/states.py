"""Figure of a flight's states: measured, predicted and desired, as the paper's Fig. 4 shows them."""

from __future__ import annotations

from typing import Any

import numpy as np

from doorman.exceptions import RecordingError
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.figures.phases import draw_phases
from doorman.visualization.style import BLACK, GREEN, RED, SKY, Axes, Figure, flight_name, widen

LOOK_AHEAD = 0.2
"""The predicted curve is what each plan says about this long after its start [s]."""
_HORIZONS = 6
"""Whole horizons that are drawn."""
_HEADING, _DOOR_ANGLE, _DOOR_RATE = 2, 3, 4
"""Places of α and α̇ in the states."""
_TRUE = ("attitude", "door_angle", "door_rate", "arm_angles")
"""Of the truth, what the states are made of."""
_PREFERRED = "preferred, one cost among others"
_ORDER = ("measured", "truth", "sensor of the door", "predicted", "horizon", "desired", _PREFERRED)
"""Of the curves in the legend."""


def states_figure(recording: Recording, model: Model) -> Figure:
    """States of a flight: measured (black), predicted by the planner (thin, dashed, red) and desired (green), as in Fig. 4.

    Desired are the door's angle and rate. Attitude and arm have preferred values (dotted): each is one cost among others, which
    the plan gives up for the door, its limits and the doorway. Measured is the state converter's estimate; the simulator's truth
    is a thin blue line where it differs. Predicted is the plan's state 0.2 s ahead, drawn at the time that it speaks of; some
    whole horizons are thin dashed lines. Bands in the background are the mission's phases, named above the first row.

    Args:
        recording: With topic `estimate`; `truth` and `plan` are drawn if they are there.
        model: Model of the scenario that was flown.

    Returns:
        The figure; `save` writes it.

    Raises:
        RecordingError: if the recording has no estimated state.
    """
    estimate = recording["estimate"]
    names = ["φ", "θ", "ψ", "α", "α̇", *(f"$\\eta_{{{i + 1}}}$" for i in range(model.n_arm))]
    rows = -(-model.nx // 3)
    figure = Figure(figsize=(11.0, 0.6 + 2.1 * rows), layout="constrained")
    panels = figure.subplots(rows, 3, sharex=True, squeeze=False).ravel()
    truth = recording.get("truth")
    true = np.empty((0, 0)) if truth is None else np.column_stack([truth[name] for name in _TRUE]).T
    if truth is not None:  # the heading without jumps at ±180°, in the turn of the estimate
        true[_HEADING] = np.unwrap(true[_HEADING])
        turns = np.round((estimate["state"][0, _HEADING] - true[_HEADING, 0]) / (2.0 * np.pi))
        true[_HEADING] += 2.0 * np.pi * turns
    for i, axes in enumerate(panels[: model.nx]):
        _draw_prediction(axes, recording, model, i)
        if truth is not None:
            off = np.interp(estimate.time, truth.time, true[i]) - estimate["state"][:, i]
            if np.nanmax(np.abs(np.degrees(off))) > 0.1:  # else it hides behind the estimate
                axes.plot(truth.time, np.degrees(true[i]), color=SKY, linewidth=0.8, label="truth", zorder=2.5)
        axes.plot(estimate.time, np.degrees(estimate["state"][:, i]), color=BLACK, linewidth=1.3, label="measured")
        goal = float(np.degrees(model.goal_state[i]))
        if i in (_DOOR_ANGLE, _DOOR_RATE):
            axes.axhline(goal, color=GREEN, linewidth=1.3, label="desired", zorder=1.5)
        else:
            axes.axhline(goal, color=GREEN, linewidth=1.0, linestyle=":", label=_PREFERRED, zorder=1.5)
        if i == _DOOR_ANGLE and "door_sensor" in recording:
            sensor = recording["door_sensor"]
            readings = sensor["leaf_time"], np.degrees(sensor["door_angle"])
            axes.plot(*readings, ".", color=SKY, markersize=1.5, label="sensor of the door", zorder=2.4)
        span = (float(estimate.time[0]), float(max(estimate.time[-1], estimate.time[0] + 1e-3)))
        axes.set_xlim(*span)
        draw_phases(axes, recording, span, named=i < 3)
        axes.set_ylabel(f"{names[i]} [deg/s]" if i == 4 else f"{names[i]} [deg]")
        widen(axes)
    for axes in panels[model.nx :]:
        axes.set_axis_off()
    for axes in panels[max(model.nx - 3, 0) : model.nx]:
        axes.set_xlabel("time [s]")
        axes.tick_params(labelbottom=True)
    figure.suptitle(f"States: {flight_name(recording)}", fontsize=11)
    _legend(figure, panels[: model.nx])
    return figure


def _legend(figure: Figure, panels: Any) -> None:
    entries: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    order = [name for name in _ORDER if name in entries]
    figure.legend([entries[name] for name in order], order, loc="outside lower center", ncols=len(order), fontsize=9)


def _draw_prediction(axes: Axes, recording: Recording, model: Model, index: int) -> None:
    if "plan" not in recording:
        return
    plan, step = recording["plan"], model.scenario.planner.time_step
    states = np.degrees(plan["states"][:, :, index])
    ahead = min(max(round(LOOK_AHEAD / step), 1), states.shape[1] - 1)
    for k in np.unique(np.linspace(0, len(states) - 1, _HORIZONS).astype(int)):
        horizon = plan.time[k] + step * np.arange(states.shape[1])
        axes.plot(horizon, states[k], color=RED, linewidth=0.5, linestyle=(0, (4, 3)), alpha=0.7, label="horizon")
    style: Any = {"color": RED, "linestyle": "--", "linewidth": 0.8, "zorder": 3}
    axes.plot(plan.time + ahead * step, states[:, ahead], label="predicted", **style)


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
            widen(axes)
        panels[len(states) - 1, column].set_xlabel("time [s]")
        panels[len(states) - 1, column].tick_params(labelbottom=True)
    panels[0, 0].set_xlim(float(estimate.time[0]), float(estimate.time[-1]))
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=9)
    return figure
