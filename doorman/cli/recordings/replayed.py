"""Every plan of a recorded run solved once more, and compared bit by bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import RecordingError
from doorman.model import Model
from doorman.planning.hinge import Hinge
from doorman.planning.plan import Plan
from doorman.planning.planner import Planner
from doorman.recording import Recording, Topic

_NEEDED = (
    "cold", "cut_short", "hinge", "goal_angle", "margin",
    "state", "states", "input", "cost", "iterations", "status",
)  # fmt: skip
_NUMBERS = ("states", "input", "cost", "iterations")


@dataclass(frozen=True)
class Difference:
    """A plan that came out otherwise than recorded."""

    plan: int  # its number in the recording, from 0
    time: float  # of its first state [s]
    fields: dict[str, float]
    """Largest difference by field; NaN where shapes differ or only one is a number. 1 for another status."""

    def __str__(self) -> str:
        fields = ", ".join(f"{name} by {amount:.3g}" for name, amount in self.fields.items() if name != "status")
        words = " and ".join(part for part in (fields, "a different status" if "status" in self.fields else "") if part)
        return f"plan {self.plan} at {self.time:.3f} s: {words}"


@dataclass(frozen=True)
class Replay:
    plans: int
    cold: int  # plans among them that began without a previous one
    differences: tuple[Difference, ...]
    not_compared: int = 0
    """Plans that the clock cut short in flight, and those that began with them: they cannot come out the same."""

    @property
    def identical(self) -> bool:
        return not self.differences

    def __str__(self) -> str:
        words = f"{self.plans} plans solved again, {self.cold} of them cold"
        if self.not_compared:
            words += f", {self.not_compared} not compared, because a time limit cut them or a predecessor short"
        differ = f"{len(self.differences)} differ."
        return f"{words}: {'every bit of states, first input, cost and status agrees.' if self.identical else differ}"


def replay_plans(recording: Recording, planner: Planner) -> Replay:
    """Solve every plan of a recording again, in order, from its recorded first state."""
    # A cold plan is made cold again; between cold plans each begins with the one before it, as in flight.
    if "plan" not in recording:
        raise RecordingError("the recording has no plans", field="topic", given="plan", allowed="a run that planned")
    recorded = recording["plan"]
    missing = [name for name in _NEEDED if name not in recorded]
    if missing:
        raise RecordingError(
            "the recording lacks what its plans were made from", field="plan", given="no " + ", ".join(missing),
            allowed="a recording of this version of doorman",
        )  # fmt: skip
    differences, comparable, left_out = [], True, 0
    make = _whole_body_plans if "whole_state" in recorded else _reduced_plans
    for k, plan in enumerate(make(recording, planner)):
        comparable = (comparable or bool(recorded["cold"][k])) and not recorded["cut_short"][k]
        left_out += not comparable
        fields = _differences(recorded, k, plan, planner) if comparable else {}
        if fields:
            differences.append(Difference(k, float(recorded.time[k]), fields))
    return Replay(len(recorded.time), int(recorded["cold"].sum()), tuple(differences), left_out)


def _reduced_plans(recording: Recording, planner: Planner) -> Iterator[Plan]:
    """Plans that begin with a reduced state."""
    recorded = recording["plan"]
    for k, start in enumerate(_starts(recording, planner.model)):
        planner.update_door(**Hinge(*map(float, recorded["hinge"][k]))._asdict())
        planner.update_margin(float(recorded["margin"][k]))
        goal = float(recorded["goal_angle"][k])
        planner.update_goal(None if goal == planner.model.goal_angle else goal)
        x = planner.planning.state(*start)
        yield planner.plan(x) if recorded["cold"][k] else planner.replan(x)


def _whole_body_plans(recording: Recording, planner: Planner) -> Iterator[Plan]:
    """Plans of the whole body: one iteration, and anew where that led nowhere."""
    recorded = recording["plan"]
    for k, x in enumerate(recorded["whole_state"]):
        planner.update_numbers(planner.numbers.named(recorded["numbers"][k]))
        plan = (
            None
            if recorded["cold"][k]
            else planner.replan(x, float(recorded["elapsed"][k]), max_iterations=planner.settings.iterations)
        )
        yield plan if plan is not None and plan.flyable else planner.plan(x)


def _starts(recording: Recording, model: Model) -> Iterator[tuple[NDArray[Any], NDArray[Any]]]:
    """Reduced state and body rates of every plan."""
    plan, rest = recording["plan"], np.zeros(3)
    if model.scenario.planner.model != "lagrangian":  # body rates are inputs there
        yield from ((state, rest) for state in plan["state"])
        return
    measured = recording["measurement"]
    for time, state in zip(plan.time, plan["state"], strict=True):
        found = np.flatnonzero(measured.time == time)
        if len(found) == 0:
            raise RecordingError("no body rates at the time of a plan", field="measurement.time", given=float(time))
        yield state, measured["body_rates"][found[-1]]


def _differences(recorded: Topic, k: int, plan: Plan, planner: Planner) -> dict[str, float]:
    """Largest difference of every field that is not the same to the bit."""
    # Recorded are the states with 32 bits, the first of the inputs, and the cost of them all.
    states, inputs = planner.planning.reduced(plan.states, plan.inputs)
    new = {"states": states.astype(np.float32), "input": inputs[0], "cost": plan.cost, "iterations": plan.iterations}
    fields = {name: _difference(recorded[name][k], new[name]) for name in _NUMBERS}
    found = {name: amount for name, amount in fields.items() if amount is not None}
    return found if recorded["status"][k] == plan.status.value else {**found, "status": 1.0}


def _difference(old: Any, new: Any) -> float | None:
    """Largest difference; None if every bit agrees, NaN counting as NaN."""
    a, b = np.array(old, dtype=np.float64, ndmin=1), np.array(new, dtype=np.float64, ndmin=1)
    if a.shape != b.shape:
        return float("nan")
    if not ((a.view(np.uint64) != b.view(np.uint64)) & ~(np.isnan(a) & np.isnan(b))).any():
        return None
    return float(np.abs(a - b).max())
