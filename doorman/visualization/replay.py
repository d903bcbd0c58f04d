"""Replay page: one HTML file that shows a recorded flight in three dimensions, and needs neither server nor network."""

from __future__ import annotations

from pathlib import Path

from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization.scene.drawing import Drawing
from doorman.visualization.scene.moments import recorded_moments
from doorman.visualization.scene.page import page


def replay_page(recording: Recording, model: Model, path: str | Path) -> Path:
    """Write a page that replays a recording: play, pause, speed, and a slider through its time.

    What is shown is the simulator's truth if the recording has it, else what was measured and estimated. Times with a value
    that is not finite are left out. An address that ends in `#t=6.5` opens the page at 6.5 s, stopped.

    Args:
        recording: With topic `truth`, or with `measurement` and `estimate`.
        model: Model of the scenario that was flown.
        path: HTML file to write.

    Returns:
        The path.

    Raises:
        RecordingError: if the recording holds no motion.
        DoormanError: if meshcat is not installed.
        OSError: if the file cannot be written.
    """
    drawing = Drawing(model)
    frames = [drawing.frame(moment) for moment in recorded_moments(recording)]
    text = page(f"doorman: {recording.header.get('name', 'replay')}", drawing.scene(), frames)
    path = Path(path)
    path.write_text(text, encoding="utf-8")
    return path
