"""Witness of a flight behind whatever autopilot: what the plant's truth shows, tick by tick, and a verdict in the end."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import RecordingError
from doorman.hardware.vehicle.places import LYING
from doorman.model import Model
from doorman.recording import Recording
from doorman.recording.files.messages import Value
from doorman.recording.recording import Topic
from doorman.rig.plant import Snapshot
from doorman.summary import COMPLETED, GOAL_MISSED, OPEN_TOLERANCE, TOUCHED, summarize
from doorman.summary.figures import where_it_ended
from doorman.summary.outcome import STANDS, STANDS_FOR

EPOCH = "epoch"
"""Topic, and field, of a recording that tells when its time was zero, by `time.monotonic` [s]."""


def judge(truth: Recording, flight: Recording, model: Model) -> dict[str, Any]:
    """Figures of a flight, as `doorman.summary.summarize` has them. What is touched on the way back and at the landing counts."""
    later = _on_the_clock_of(flight, truth) > float(flight["mission"].time[-1])
    return summarize(together(truth, flight), model, int(truth["truth"]["collisions"][later].sum()))


def together(truth: Recording, flight: Recording) -> Recording:
    """The flight's recording with the truth in it, on the flight's clock and for the time of the mission."""
    time, estimate = _on_the_clock_of(flight, truth), flight["estimate"]
    during = (time >= float(estimate.time[0])) & (time <= float(flight["mission"].time[-1]))
    if not during.any():
        raise RecordingError("the rig's recording does not cover the flight", field="truth")
    ticks, rows = time[during], truth["truth"]
    newest = _newest(estimate.time, ticks)  # summaries compare estimate and truth row by row
    topics: dict[str, Topic] = {
        **flight,
        "truth": Topic("truth", ticks, {name: rows[name][during] for name in rows}),
        "estimate": Topic("estimate", ticks, {name: estimate[name][newest] for name in estimate}),
    }
    return Recording(topics, flight.header, truth.complete and flight.complete)


def _on_the_clock_of(flight: Recording, truth: Recording) -> NDArray[np.float64]:
    """Times of the truth; the plant's zero moves where the plant fell behind the clock."""
    epochs, time = truth[EPOCH], truth["truth"].time
    at: NDArray[np.float64] = time + epochs[EPOCH][_newest(epochs.time, time)] - float(flight[EPOCH][EPOCH][0])
    return at


def _newest(times: NDArray[np.float64], now: NDArray[np.float64]) -> NDArray[np.intp]:
    """Rows of the newest messages."""
    return np.maximum(np.searchsorted(times, now, side="right") - 1, 0)


NOT_FLOWN, NOT_LANDED = "not flown", "not landed"
_AFTER_CONTACT = 1.0
"""Sinking counts until so long after the tip has left the leaf [s]."""


class Witness:
    def __init__(self, model: Model) -> None:
        self._model = model
        self._flown = False
        self._angle, self._rates = model.start_angle, deque[tuple[float, float]]()
        self._touched: dict[str, list[float]] = {}
        self._push = self._pull = self._sinking = 0.0
        self._touching_at, self._height = -math.inf, math.nan
        self._last = math.nan

    def note(self, topic: str, time: float, fields: Mapping[str, Value]) -> None:
        if topic != "truth":
            return
        truth: Mapping[str, Any] = fields
        step, self._last, self._flown = time - self._last, time, True
        self._angle = float(truth["door_angle"])
        self._rates.append((time, float(truth["door_rate"])))
        while self._rates[0][0] < time - STANDS_FOR:
            self._rates.popleft()
        self._push, self._pull = max(self._push, float(truth["max_push"])), max(self._pull, float(truth["max_pull"]))
        feels = "frame" in self._model.scenario.mission.measures and truth["only_tip_on_frame"]
        if truth["collisions"] and not feels:
            for pair in str(truth["collision_pairs"]).split(", "):
                first_and_time = self._touched.setdefault(pair, [time, 0.0])
                first_and_time[1] += step if math.isfinite(step) else 0.0
        if truth["touching"]:
            if time - self._touching_at > _AFTER_CONTACT:
                self._height = float(truth["position"][2])
            self._touching_at = time
        if time - self._touching_at <= _AFTER_CONTACT:  # below the height at the first touch of every attempt
            self._sinking = max(self._sinking, self._height - float(truth["position"][2]))

    def judged(self, end: Snapshot) -> dict[str, Any]:
        """Figures of the flight, with the names of `summary.json` where it has them."""
        rates, goal = [rate for _, rate in self._rates], self._model.goal_angle
        stands = not rates or abs(sum(rates) / len(rates)) < STANDS
        opened = self._flown and stands and abs(self._angle - goal) < OPEN_TOLERANCE
        roll, pitch = (float(angle) for angle in end.truth.attitude[:2])
        landed = self._flown and not end.motors and end.on_ground and max(abs(roll), abs(pitch)) < LYING
        outcome = COMPLETED if opened else GOAL_MISSED
        if self._touched:
            outcome = TOUCHED
        elif not landed:
            outcome = NOT_LANDED
        return {
            "outcome": outcome if self._flown else NOT_FLOWN,
            "opened": opened,
            "landed": landed,
            "final_door_angle_deg": math.degrees(self._angle),
            "target_door_angle_deg": math.degrees(goal),
            **where_it_ended(self._model.true_door, self._angle, goal),
            "touched": [
                {"pair": pair, "first_s": first, "duration_s": duration}
                for pair, (first, duration) in self._touched.items()
            ],
            "max_sinking_m": self._sinking,
            "max_push_force_n": self._push,
            "max_pull_force_n": self._pull,
        }


def verdict(figures: Mapping[str, Any]) -> tuple[bool, str]:
    """Whether the door was opened, nothing touched and the vehicle landed, and a sentence that says what happened."""
    if figures["outcome"] == NOT_FLOWN:
        return False, "Nothing was flown."
    turns = figures["unit"] == "deg"
    unit, digits, name = ("°", 1, "door_angle_deg") if turns else (" m", 3, "opening")
    at, goal = figures[f"final_{name}"], figures[f"target_{name}"]
    where = (
        f"the door ended at {at:.{digits}f}{unit}, {abs(figures['final_error']):.{digits}f}{unit} from the target of "
        f"{goal:.{digits}f}{unit}; at the leaf the vehicle sank by up to {100 * figures['max_sinking_m']:.0f} cm, pushed with up "
        f"to {figures['max_push_force_n']:.1f} N and pulled with up to {figures['max_pull_force_n']:.1f} N"
    )
    if figures["touched"]:
        pairs = ", ".join(f"{one['pair']} for {one['duration_s']:.2f} s" for one in figures["touched"])
        return False, f"Something was touched ({pairs}); {where}."
    if not figures["landed"]:
        return False, f"The vehicle has not landed; {where}."
    opened = "was opened and nothing was touched" if figures["opened"] else "was not opened"
    return bool(figures["opened"]), f"The door {opened}; {where}."
