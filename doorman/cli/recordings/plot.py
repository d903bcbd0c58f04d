"""`doorman plot`: the figures of a recorded run, once more."""

from __future__ import annotations

import json
from pathlib import Path

import typer

from doorman.cli.recordings.recorded import loaded_run, recorded_scenario
from doorman.model import Model
from doorman.visualization import write_pictures


def plot_run(run: Path | None, out: Path | None, as_json: bool) -> int:
    file, recording = loaded_run(run, as_json)
    model = Model(recorded_scenario(recording, file))
    folder = out or file.parent
    files = write_pictures(recording, model, folder)
    if as_json:
        typer.echo(json.dumps({"complete": recording.complete, "files": [str(path) for path in files]}, indent=2))
        return 0
    for path in files:
        typer.echo(str(path))
    return 0
