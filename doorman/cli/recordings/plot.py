"""`doorman plot`: the figures of a recorded run, once more."""

from __future__ import annotations

import json
from pathlib import Path

import typer

from doorman.cli.recordings.recorded import chosen_recording, recorded_scenario, say_what_is_missing
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization import write_pictures


def plot_run(run: Path | None, out: Path | None, as_json: bool) -> int:
    """Draw the figures and the replay page of a recording.

    Args:
        run: Folder of the run, or its MCAP file; None: the newest one under `runs`.
        out: Folder to write to; by default that of the recording.
        as_json: Print the files as JSON and nothing else.

    Returns:
        Exit status: 0.

    Raises:
        RecordingError: if there is no recording to read, or it lacks what a figure shows.
        DoormanError: if its scenario cannot be made a model.
        OSError: if a file cannot be written.
    """
    file = chosen_recording(run)
    recording = Recording.load(file)
    say_what_is_missing(recording, err=as_json)
    model = Model(recorded_scenario(recording, file))
    folder = out or file.parent
    files = write_pictures(recording, model, folder)
    if as_json:
        typer.echo(json.dumps({"complete": recording.complete, "files": [str(path) for path in files]}, indent=2))
        return 0
    for path in files:
        typer.echo(str(path))
    return 0
