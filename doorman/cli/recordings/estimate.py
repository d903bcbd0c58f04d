"""`doorman estimate`: a recorded run through the filter at the leaf, with other numbers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import typer

from doorman.cli.recordings.recorded import loaded_run, recorded_scenario
from doorman.estimation.leaf.numbers import JOINT, JOINT_RATE
from doorman.estimation.leaf.replay import LeafReplay, replay_leaf
from doorman.estimation.status import Status
from doorman.exceptions import DoormanError
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.figures.estimate import estimate_figure
from doorman.visualization.style import save

_LEAF = [JOINT, JOINT_RATE]


def estimate_run(run: Path | None, changes: list[str], out: Path | None, as_json: bool) -> int:
    file, recording = loaded_run(run, as_json)
    model = Model(recorded_scenario(recording, file))
    found = replay_leaf(recording, model, dict(map(_change, changes)))
    picture, _ = save(estimate_figure(recording, model, found), out or file.parent, "estimate")
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
        "log_likelihood": round(found.log_likelihood, 1), "mean_nis_of_3": round(found.mean_nis, 3),
        "refused_poses": found.refused, "begun_anew": int((found.statuses == Status.LOST).sum()),
        "slips": int((np.diff(found.slips.astype(int), prepend=0) > 0).sum()),
    }  # fmt: skip
    if "truth" in recording:
        figures["mean_nees_of_2"] = round(float(np.mean(_nees(recording, found))), 3)
    return figures


def _nees(recording: Recording, found: LeafReplay) -> Any:
    """Normalised error squared of the leaf's angle and rate at the poses' times, as if both were independent."""
    truth = recording["truth"]
    errors = np.column_stack([
        found.mean[:, _LEAF[i]] - np.interp(found.pose_time, truth.time, truth[name])
        for i, name in enumerate(("door_angle", "door_rate"))
    ])  # fmt: skip
    return ((errors / found.deviations[:, _LEAF]) ** 2).sum(axis=1)
