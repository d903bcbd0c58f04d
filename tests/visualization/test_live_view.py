"""Live view, as a browser would ask it: the same frames as the replay's, from the start, up to the end."""

from __future__ import annotations

import json
import urllib.request
from urllib.error import HTTPError

import numpy as np
import pytest

from doorman.exceptions import DoormanError
from doorman.recording import Recorder
from doorman.visualization import LiveView
from doorman.visualization.drawing import Drawing
from doorman.visualization.moments import recorded_moments


def events(view):
    """Frames that were sent, and the name of the last event."""
    with urllib.request.urlopen(f"{view.url}frames", timeout=60) as answer:
        blocks = answer.read().decode().strip().split("\n\n")
    frames = [frame for block in blocks if block.startswith("data: ") for frame in json.loads(block[6:])]
    return frames, blocks[-1]


def test_frames_are_those_of_the_replay(model, fly_into):
    with LiveView(model, "live") as view, Recorder(None, {}, view.listen) as recorder:
        fly_into(recorder, model, 0.0, 1.0)
        assert not view.end(patience=0.0)
        first, last = events(view)
        again, _ = events(view)
        assert last.startswith("event: end") and again == first
        assert view.end(patience=60.0)
    replayed = [Drawing(model).frame(moment) for moment in recorded_moments(recorder.recording())]
    assert len(first) == pytest.approx(len(replayed), abs=1)
    for frame in first[::10]:
        nearest = min(replayed, key=lambda other: abs(other["time"] - frame["time"]))
        np.testing.assert_allclose(frame["poses"], nearest["poses"], atol=0.02)  # up to 1/60 s apart
        assert frame["phase"] in ("touch", "open") and len(frame["clearances"]) == 4


def test_a_flight_without_truth_is_shown_by_its_estimate(model, fly):
    recording = fly(model, 0.5, with_truth=False)
    with LiveView(model, "live") as view:
        for topic in ("measurement", "estimate"):
            fields = {name: recording[topic][name][0] for name in recording[topic]}
            view.listen(topic, 0.0, fields)
        view.listen("estimate", 0.1, {"state": fields["state"] * np.nan})  # the first tick's pose, a broken angle
        view.end()
        (frame,), _ = events(view)
    assert frame["door_angle"] == pytest.approx(np.degrees(recording["estimate"]["state"][0, 3]), abs=0.01)


def test_nothing_else_is_served(model):
    with LiveView(model, "live") as view:
        assert view.url.startswith("http://127.0.0.1:")
        with pytest.raises(HTTPError, match="404"):
            urllib.request.urlopen(f"{view.url}../etc/passwd", timeout=60)
        with (
            pytest.raises(DoormanError, match="port"),
            LiveView(model, "another", int(view.url.rsplit(":", 1)[1][:-1])),
        ):
            pass
    with pytest.raises(DoormanError, match="not open"):
        view.url  # noqa: B018
