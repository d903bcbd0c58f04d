"""All pictures of a run in its folder: the same after a flight and from a recording."""

from __future__ import annotations

from pathlib import Path

from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.constraint_figure import constraints_and_forces_figure
from doorman.visualization.figures import states_figure
from doorman.visualization.replay import replay_page
from doorman.visualization.style import save
from doorman.visualization.swing_figure import swing_figure
from doorman.visualization.timing_figure import planner_time_figure


def write_pictures(recording: Recording, model: Model, folder: Path) -> list[Path]:
    """Draw the figures and the replay page of a run.

    Args:
        recording: The run.
        model: Model of the scenario that was flown.
        folder: Where to write.

    Returns:
        The files.

    Raises:
        RecordingError: if the recording lacks what a figure shows.
        OSError: if a file cannot be written.
    """
    return [
        *save(states_figure(recording, model), folder, "states"),
        *save(constraints_and_forces_figure(recording, model), folder, "constraints"),
        *save(swing_figure(recording, model), folder, "swing"),
        *save(planner_time_figure(recording, model), folder, "planner_time"),
        replay_page(recording, model, folder / "replay.html"),
    ]
