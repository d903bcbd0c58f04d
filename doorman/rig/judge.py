"""Judge of a flight against the rig: what the rig knows to be true, and what the flight recorded, on one clock."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import RecordingError
from doorman.model import Model
from doorman.recording import Recording
from doorman.recording.recording import Topic
from doorman.summary import summarize

EPOCH = "epoch"
"""Topic, and field, of a recording that tells when its time was zero, by `time.monotonic` [s]."""


def judge(truth: Recording, flight: Recording, model: Model) -> dict[str, Any]:
    """Figures of a flight, as `doorman.summary.summarize` has them. What is touched on the way back and at the landing counts."""
    later = truth["truth"].time + _epochs_along(truth) - _epoch(flight) > float(flight["mission"].time[-1])
    return summarize(together(truth, flight), model, int(truth["truth"]["collisions"][later].sum()))


def together(truth: Recording, flight: Recording) -> Recording:
    """The flight's recording with the truth in it, on the flight's clock and for the time of the mission."""
    begin, end = _epoch(flight), float(flight["mission"].time[-1])
    time = truth["truth"].time + _epochs_along(truth) - begin
    first = float(flight["estimate"].time[0])
    during = (time >= first) & (time <= end)
    if not during.any():
        raise RecordingError("the rig's recording does not cover the flight", field="truth")
    topics: dict[str, Topic] = dict(flight)
    topics["truth"] = _rows(truth["truth"], time, during)
    ticks = topics["truth"].time
    topics["estimate"] = _nearest(flight["estimate"], ticks)
    return Recording(topics, flight.header, truth.complete and flight.complete)


def _epoch(recording: Recording) -> float:
    return float(recording[EPOCH][EPOCH][0])


def _epochs_along(truth: Recording) -> NDArray[np.float64]:
    """When the plant's time was zero, at every tick: it moves where the plant fell behind the clock."""
    epochs = truth[EPOCH]
    newest = np.searchsorted(epochs.time, truth["truth"].time, side="right") - 1
    values: NDArray[np.float64] = epochs[EPOCH][np.maximum(newest, 0)]
    return values


def _rows(topic: Mapping[str, NDArray[Any]], time: NDArray[np.float64], chosen: NDArray[np.bool_]) -> Topic:
    return Topic("truth", time[chosen], {name: topic[name][chosen] for name in topic})


def _nearest(topic: Topic, times: NDArray[np.float64]) -> Topic:
    """The newest message at every time: summaries compare estimate and truth row by row."""
    newest = np.maximum(np.searchsorted(topic.time, times, side="right") - 1, 0)
    return Topic(topic.name, times, {name: topic[name][newest] for name in topic})
