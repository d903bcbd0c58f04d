"""`doorman estimate`: a recorded run through the filter at the leaf, with other numbers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from doorman.cli.command import LOOK, command
from doorman.cli.options import Json, Run, folder, valued
from doorman.exceptions import DoormanError

if TYPE_CHECKING:  # commands import what they run when they run it
    from doorman.control.estimation.replay import LeafReplay
    from doorman.recording import Recording


@command(LOOK)
def estimate(
    run: Run = None,
    changes: Annotated[
        list[str] | None, valued("NAME=NUMBER", "A number of the filter, such as noise.wind=0.3.", True, "--set")
    ] = None,
    out: Annotated[Path | None, folder("the recording's")] = None,
    as_json: Json = False,
) -> int:
    """Replay a recorded run's poses and commands through a filter of vehicle and leaf, and draw what it knows.

    The command prints the log-likelihood and the mean normalised innovation squared (NIS) of the poses. With the truth of a
    simulation it also prints the mean normalised error squared (NEES) of the leaf's angle and rate. The picture shows angle,
    normal force, two deviations of each, truth, and the probability of each hypothesis (estimate.png).

    Missions fly on this filter. `--set` shows what other numbers would have made of the same flight.
    """
    from doorman.cli.recordings.recorded import loaded_run, recorded_model
    from doorman.cli.terminal.display import print_result
    from doorman.control.estimation.replay import replay_leaf
    from doorman.visualization.figures.estimate import estimate_figure
    from doorman.visualization.style import save

    file, recording = loaded_run(run, as_json)
    model = recorded_model(recording, file)
    found = replay_leaf(recording, model, dict(map(_change, changes or [])))
    picture, _ = save(estimate_figure(recording, model, found), out or file.parent, "estimate")
    figures = _figures(recording, found) | {"picture": str(picture)}
    print_result(as_json, figures, [f"{name}: {value}" for name, value in figures.items()])
    return 0


def _change(text: str) -> tuple[str, float]:
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise DoormanError("not a change", field="--set", given=text, allowed="NAME=NUMBER") from None


def _figures(recording: Recording, found: LeafReplay) -> dict[str, Any]:
    import numpy as np

    from doorman.estimation.leaf.numbers import part
    from doorman.estimation.status import Status

    figures: dict[str, Any] = {
        "log_likelihood": round(found.log_likelihood, 1), "mean_nis_of_3": round(found.mean_nis, 3),
        "refused_poses": found.refused, "begun_anew": int((found.statuses == Status.LOST).sum()),
        "slips": int((np.diff(found.slips.astype(int), prepend=0) > 0).sum()),
    }  # fmt: skip
    if "truth" in recording:  # as if angle and rate were independent
        truth, leaf = recording["truth"], {"door_angle": "joint", "door_rate": "joint_rate"}
        errors = [
            (part(found.mean, own) - np.interp(found.pose_time, truth.time, truth[name])) / part(found.deviations, own)
            for name, own in leaf.items()
        ]
        figures["mean_nees_of_2"] = round(float(np.square(errors).sum(axis=0).mean()), 3)
    return figures
