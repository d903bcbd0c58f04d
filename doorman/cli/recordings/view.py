"""`doorman view`: a recorded run in the browser."""

from __future__ import annotations

import json
from pathlib import Path

import typer

from doorman.cli.recordings.recorded import loaded_run, recorded_scenario
from doorman.cli.terminal.browser import show_in_browser
from doorman.model import Model
from doorman.visualization.replay import replay_page


def view_run(run: Path | None, output: Path | None, as_json: bool) -> int:
    """Write the page of a recording, and open it unless a file was asked for."""
    file, recording = loaded_run(run, as_json)
    model = Model(recorded_scenario(recording, file))
    page = replay_page(recording, model, output or file.parent / "replay.html")
    shown = output is None and show_in_browser(page.resolve().as_uri())
    if as_json:
        typer.echo(json.dumps({"complete": recording.complete, "file": str(page), "opened": shown}, indent=2))
        return 0
    typer.echo(f"{page}{'' if shown or output else ' (open it in a browser)'}")
    return 0
