"""Figure of a flight that was replayed through the filter at the leaf: angle, force and hypotheses, beside the truth."""

from __future__ import annotations

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.replay import LeafReplay
from doorman.estimation.leaf.numbers import part
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.style import BLACK, BLUE, CYCLE, Figure, flight_name


def estimate_figure(recording: Recording, model: Model, found: LeafReplay) -> Figure:
    """The leaf's joint, the tip's force and the probabilities of the hypotheses, with bands of two deviations."""
    figure = Figure(figsize=(9.0, 7.0), layout="constrained")
    angle, force, chance = figure.subplots(3, 1, sharex=True)
    door = model.door
    unit = 1.0 if door.slides else 180.0 / np.pi
    joint, deviation = _opening(model, found.joint), part(found.deviations, "joint")
    pressed, spread = found.normal_force.T
    around = 2.0 * unit * door.per_angle * deviation
    for axes, value, band in ((angle, unit * joint, around), (force, pressed, 2.0 * spread)):
        low, high = value - band, value + band
        axes.fill_between(found.time, low, high, color=BLUE, alpha=0.25, linewidth=0, label="two deviations")
        axes.plot(found.time, value, color=BLUE, linewidth=1.4, label="estimate")
        axes.grid(alpha=0.3)
    for place, name in enumerate(found.hypotheses):
        color = CYCLE[place % len(CYCLE)]
        chance.plot(found.time, found.probabilities[:, place], color=color, linewidth=1.4, label=name)
    if "truth" in recording:
        truth = recording["truth"]
        angle.plot(truth.time, unit * _opening(model, truth["door_angle"]), color=BLACK, linestyle=":", label="truth")
        force.plot(truth.time, truth["tip_normal_force"], color=BLACK, linestyle=":", linewidth=0.8, label="truth")
    angle.set_ylabel("opening [m]" if door.slides else "opening [°]")
    force.set_ylabel("normal force [N]")
    chance.set_ylabel("probability")
    chance.set_xlabel("time [s]")
    chance.grid(alpha=0.3)
    angle.legend(fontsize=8, loc="best")
    chance.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.suptitle(f"Replay through the filter at the leaf: {flight_name(recording)}", fontsize=11)
    return figure


def _opening(model: Model, door_angles: Array) -> Array:
    """How far the door is open at many angles [rad or m]."""
    return np.array([model.door.opening_of(angle) for angle in np.asarray(door_angles).tolist()])
