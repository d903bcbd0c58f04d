"""Figure of what limits a flight: constraints, force at the tip, thrust, disturbance and the planner's time."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recording
from doorman.summary.flown_constraints import flown_constraints
from doorman.visualization.figures.phases import tied
from doorman.visualization.style import (
    BLACK,
    BLUE,
    CYCLE,
    GREEN,
    ORANGE,
    RED,
    SKY,
    Axes,
    Figure,
    FuncFormatter,
    flight_name,
    not_recorded,
)

_LABELS = (
    "h: arm below the body [m]", "h: disc clear of the door [m]", "tip force on the door along $n_D$ [N]", "thrust [N]",
    "estimated disturbance [N]", "planner's time [ms]",
)  # fmt: skip
"""Labels of the panels, row by row."""


def constraints_and_forces_figure(recording: Recording, model: Model) -> Figure:
    """Collision constraints, force at the tip, thrust, disturbance and the planner's time over a flight.

    The constraints are those of the true states against the true door where there are any, else of the estimate, from the touch
    until the tip lets go. The planned force is that of the plan's first input on a door that stands, n_Dᵀ(f_t R e₃ − m g e₃).

    Args:
        recording: What was flown; a panel whose topic is missing says so.
        model: Model of the scenario that was flown.

    Returns:
        The figure; `save` writes it.
    """
    figure = Figure(figsize=(11.0, 8.4), layout="constrained")
    panels = figure.subplots(3, 2, sharex=True).ravel()
    arm = len(model.vehicle.point_names)
    _draw_constraints(panels[0], recording, model, range(arm))
    _draw_constraints(panels[1], recording, model, range(arm, model.n_constraints))
    _draw_user_rows(panels[1], recording)
    _draw_tip_force(panels[2], recording, model)
    _draw_thrust(panels[3], recording, model)
    _draw_disturbance(panels[4], recording)
    _draw_solve_time(panels[5], recording, model)
    for k, (axes, label) in enumerate(zip(panels, _LABELS, strict=True)):
        axes.set_ylabel(label)
        axes.grid(alpha=0.3, which="both" if axes.get_yscale() == "log" else "major")
        if axes.get_legend_handles_labels()[0]:
            above = k < 2  # the curves, in room of its own
            axes.legend(fontsize=7, framealpha=0.8, loc="upper center" if above else "best", ncols=3 if above else 1,
                        columnspacing=1.0, handlelength=1.7)  # fmt: skip
        else:
            not_recorded(axes)
    for axes in panels[-2:]:
        axes.set_xlabel("time [s]")
    figure.suptitle(f"Constraints and forces: {flight_name(recording)}", fontsize=11)
    return figure


def _draw_constraints(axes: Axes, recording: Recording, model: Model, rows: range) -> None:
    if "truth" in recording:  # against the true door, else as the planner has them
        truth = recording["truth"]
        time = truth.time
        h = flown_constraints(model, *(truth[name] for name in ("position", "attitude", "door_angle", "arm_angles")))
        h = np.where(np.isfinite(h), h, np.nan)[:, rows.start : rows.stop]
    elif "estimate" in recording:
        time = recording["estimate"].time
        h = model.constraints_along(recording["estimate"]["state"])[:, rows.start : rows.stop]
    else:
        return
    h[~tied(recording, time)] = np.nan  # they are about a vehicle whose tip is at the door
    for k, name in enumerate(model.constraint_names[rows.start : rows.stop]):
        style = ("-", "--", "-.", ":")[k % 4]
        axes.plot(time, h[:, k], color=CYCLE[k % len(CYCLE)], linestyle=style, linewidth=1.3, label=name)
    axes.axhline(0.0, color=BLACK, linewidth=0.9)
    low, high = axes.get_ylim()
    high = max(high, 0.04, -0.3 * low)  # with room for the legend
    margin = model.scenario.planner.margin
    axes.axhspan(0.0, high, color=RED, alpha=0.15, linewidth=0, label="not allowed")
    if margin > 0.0:
        axes.axhspan(-margin, 0.0, color=ORANGE, alpha=0.25, linewidth=0, label=f"planner's margin {margin:g} m")
    axes.set_ylim(low, high)


def _draw_user_rows(axes: Axes, recording: Recording) -> None:
    """Rows that the user has added to the planner's problem, at their worst along each plan."""
    if "plan" not in recording or "user_rows" not in recording["plan"]:
        return
    plan = recording["plan"]
    for k, name in enumerate(plan["user_row_names"][0]):
        axes.plot(plan.time, plan["user_rows"][:, k], color=BLACK, linestyle=("-", "--", "-.", ":")[k % 4], linewidth=0.9,
                  label=f"{name} (planned)")  # fmt: skip


def _draw_tip_force(axes: Axes, recording: Recording, model: Model) -> None:
    if "truth" in recording:
        truth = recording["truth"]
        axes.plot(truth.time, truth["tip_normal_force"], color=BLACK, linewidth=0.9, label="true")
    if "estimate" in recording and "normal_force" in recording["estimate"]:
        estimate = recording["estimate"]
        axes.plot(estimate.time, estimate["normal_force"], color=BLUE, linewidth=0.9, label="estimated")
    if "plan" in recording:
        plan = recording["plan"]
        axes.plot(plan.time, planned_normal_force(plan["states"][:, 0], plan["input"], model), color=RED,
                  linestyle="--", linewidth=1.2, label="planned")  # fmt: skip
    if axes.lines:
        axes.axhline(0.0, color=BLACK, linewidth=0.9)
        low = min(axes.get_ylim()[0], -1.0)
        axes.axhspan(low, 0.0, color=SKY, alpha=0.2, linewidth=0, label="pulls")
        axes.set_ylim(bottom=low)


def planned_normal_force(states: Array, inputs: Array, model: Model) -> Array:
    weight = np.array([0.0, 0.0, model.vehicle.weight])
    force = np.full(len(states), np.nan)
    for k in np.flatnonzero(np.isfinite(states).all(axis=1)):
        lift = inputs[k, 0] * rotation_body_to_world(states[k, :3])[:, 2]
        force[k] = model.door.normal(states[k, 3]) @ (lift - weight)
    return force


def _draw_thrust(axes: Axes, recording: Recording, model: Model) -> None:
    if "command" not in recording:
        return
    command = recording["command"]
    axes.plot(command.time, command["thrust"], color=BLACK, linewidth=1.0, label="commanded", zorder=3)
    axes.axhline(model.vehicle.max_thrust, color=RED, linestyle="--", linewidth=1.2, label="limit")
    axes.axhline(model.vehicle.weight, color=GREEN, linewidth=1.0, label="weight")
    axes.set_ylim(0.0, 1.08 * model.vehicle.max_thrust)


def _draw_disturbance(axes: Axes, recording: Recording) -> None:
    if "controller" in recording:
        controller = recording["controller"]
        for k, (name, style) in enumerate(zip("xyz", ("-", "--", "-."), strict=True)):
            values = controller["disturbance"][:, k]
            axes.plot(controller.time, values, color=CYCLE[k], linestyle=style, linewidth=1.1, label=name)


def _draw_solve_time(axes: Axes, recording: Recording, model: Model) -> None:
    if "plan" not in recording:
        return
    plan, deadline = recording["plan"], 1e3 / model.scenario.planner.rate
    milliseconds = 1e3 * plan["solve_time"]
    axes.plot(plan.time, milliseconds, color=BLACK, linewidth=0.8, label="solve")
    axes.axhline(deadline, color=RED, linestyle="--", linewidth=1.2, label=f"deadline {deadline:g} ms")
    missed = plan["deadline_missed"]
    if missed.any():
        words = f"missed: {missed.sum()}"
        axes.plot(plan.time[missed], milliseconds[missed], "x", color=RED, markersize=5, label=words)
    axes.set_yscale("log")
    positive = milliseconds[milliseconds > 0.0]
    if positive.size:  # whole decades
        low, high = np.log10(min(positive.min(), deadline)), np.log10(max(positive.max(), 1.5 * deadline))
        axes.set_ylim(float(10.0 ** np.floor(low)), float(10.0 ** np.ceil(high)))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
