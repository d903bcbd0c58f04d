"""A recorded run as the command line takes it: which one, what it holds, and the scenario that was flown."""

from __future__ import annotations

from pathlib import Path

import typer

from doorman import flown
from doorman.model import Model
from doorman.recording import Recording
from doorman.recording.runs import newest_recording, recording_file
from doorman.scenario import Scenario


def loaded_run(run: Path | None, as_json: bool) -> tuple[Path, Recording]:
    """A run's file and what it holds; what it has lost is said, with JSON on stderr."""
    file = chosen_recording(run)
    recording = Recording.load(file)
    say_what_is_missing(recording, err=as_json)
    return file, recording


def chosen_recording(run: Path | None) -> Path:
    if run is not None:
        return recording_file(run)
    file = newest_recording()
    typer.echo(f"The newest run: {file}", err=True)
    return file


def recorded_scenario(recording: Recording, file: Path) -> Scenario:
    """The scenario that was flown; a warning on stderr if keys of it are not known."""
    return flown.recorded_scenario(recording, file.parent, lambda words: typer.echo(f"Warning: {words}", err=True))


def recorded_model(recording: Recording, file: Path) -> Model:
    return Model(recorded_scenario(recording, file))


def say_what_is_missing(recording: Recording, err: bool) -> None:
    """Say what a recording has lost, if anything."""
    if recording.damaged_chunks:
        chunks = "1 chunk" if recording.damaged_chunks == 1 else f"{recording.damaged_chunks} chunks"
        typer.echo(f"The recording is damaged: {chunks} could not be read; the result lacks its data.", err=err)
    for topic, count in recording.damaged_messages.items():
        typer.echo(f"The recording is damaged: {count} of the messages of {topic} are left out.", err=err)
    if not (recording.complete or recording.damaged_chunks or recording.damaged_messages):
        typer.echo("The recording was cut off; the result ends early.", err=err)
