"""`doorman estimate`: a recorded run through the filter at the leaf, with other numbers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import typer

from doorman.cli.recordings.recorded import chosen_recording, recorded_scenario, say_what_is_missing
from doorman.estimation.leaf.replay import LeafReplay, replay_leaf
from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.recording import Recording

_JOINT = slice(9, 11)
"""Place of q and its rate among the states."""


def estimate_run(run: Path | None, changes: list[str], out: Path | None, as_json: bool) -> int:
    """Replay, figures and picture."""
    file = chosen_recording(run)
    recording = Recording.load(file)
    say_what_is_missing(recording, err=as_json)
    found = replay_leaf(recording, Model(recorded_scenario(recording, file)), dict(map(_change, changes)))
    picture = (out or file.parent) / "estimate.png"
    picture.parent.mkdir(parents=True, exist_ok=True)
    _draw(recording, found, picture)
    figures = _figures(recording, found) | {"picture": str(picture)}
    lines = [f"{name}: {value}" for name, value in figures.items()]
    typer.echo(json.dumps(figures, indent=2) if as_json else "\n".join(lines))
    return 0


def _change(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise DoormanError("not a change", field="--set", given=text, allowed="NAME=NUMBER") from None


def _figures(recording: Recording, found: LeafReplay) -> dict[str, Any]:
    figures: dict[str, Any] = {
        "log_likelihood": round(found.log_likelihood, 1), "mean_nis_of_3": round(found.poses.mean_nis, 3),
        "refused_poses": found.poses.refused,
    }  # fmt: skip
    if "truth" in recording:
        figures["mean_nees_of_2"] = round(float(np.mean(_nees(recording, found))), 3)
    return figures


def _nees(recording: Recording, found: LeafReplay) -> Any:
    """Of the leaf's angle and rate at the poses' time, as if both were independent."""
    truth = recording["truth"]
    errors = np.column_stack([
        found.mean[:, _JOINT][:, i] - np.interp(found.pose_time, truth.time, truth[name])
        for i, name in enumerate(("door_angle", "door_rate"))
    ])  # fmt: skip
    return ((errors / found.deviations[:, _JOINT]) ** 2).sum(axis=1)


def _draw(recording: Recording, found: LeafReplay, picture: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 7), layout="constrained")
    angle, force, chance = figure.subplots(3, 1, sharex=True)
    band = 2.0 * found.deviations[:, 9]
    angle.fill_between(found.time, found.joint - band, found.joint + band, alpha=0.3, label="two deviations")
    angle.plot(found.time, found.joint, label="estimate")
    value, spread = found.normal_force.T
    force.fill_between(found.time, value - 2.0 * spread, value + 2.0 * spread, alpha=0.3)
    force.plot(found.time, value)
    chance.stackplot(found.time, *found.probabilities.T, labels=found.hypotheses)
    if "truth" in recording:
        truth = recording["truth"]
        angle.plot(truth.time, truth["door_angle"], "k:", label="truth")
        force.plot(truth.time, truth["tip_normal_force"], "k:", linewidth=0.5)
    angle.set_ylabel("joint [rad or m]")
    force.set_ylabel("normal force [N]")
    chance.set_ylabel("probability")
    chance.set_xlabel("time [s]")
    angle.legend()
    chance.legend()
    figure.savefig(picture, dpi=120)
