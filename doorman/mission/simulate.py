"""A whole flight in simulation, recorded and summarised."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Any

from doorman.checks import positive, whole
from doorman.exceptions import DoormanError
from doorman.feasibility import FeasibilityWarning, Report, check
from doorman.flown import carried_files, recorded_header
from doorman.mission.mission import Mission, OnProgress
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Listener, Recorder, Recording
from doorman.scenario import Scenario
from doorman.stages import stages
from doorman.summary import summarize

_PREPARATION = 0.1
"""Length of a flight that only compiles [s]."""


def simulate(
    scenario: Scenario | Model | str | os.PathLike[str],
    duration: float | None = None,
    seed: int = 0,
    *,
    path: str | os.PathLike[str] | None = None,
    realtime: bool = False,
    planner: Planner | None = None,
    on_progress: OnProgress | None = None,
    listener: Listener | None = None,
    force: bool = False,
    report: Report | None = None,
) -> Recording:
    """Fly a scenario in simulation, if `doorman.feasibility.check` finds that it can work.

    The recording's header holds what the check finds. Warnings of a check made here are issued as `FeasibilityWarning`.

    Args:
        scenario: The scenario, its name or path, or a model of it that exists already.
        duration: Simulated time at most, > 0 [s]; to the mission's end if not given.
        seed: Of the sensors' noise and the gusts, an integer >= 0.
        path: MCAP file to record to, which carries the URDFs, and whose directory is made; in memory only if not given.
        realtime: Do not run ahead of the wall clock.
        planner: Planner of the same scenario, to save its construction.
        on_progress: Called once per planner period with time and estimated door angle.
        listener: Called with topic, time and fields of everything that is recorded, as it is recorded.
        force: Fly even what the check refuses; without a report, nothing is checked.
        report: Of the check, where it was made before; else it is made here, in seconds.

    Returns:
        The recording, with its summary. After Ctrl-C it holds what was flown until then.

    Raises:
        InfeasibleError: if the check refuses the scenario; nothing is flown.
        DoormanError: if the scenario is unusable or the simulation fails.
    """
    from doorman import __version__
    from doorman.simulation import SimulatedBackend  # needs the extra `sim`

    duration = None if duration is None else positive(duration, "duration")
    seed = whole(seed, "seed", 0)
    file = None if path is None else _file(path)
    model = scenario if isinstance(scenario, Model) else Model(scenario)
    report = checked(model, force, report)
    header = recorded_header(model.scenario) | {
        "seed": seed,
        "duration": duration,
        "version": __version__,
        "forced": force,
        "findings": None if report is None else [finding.as_dict() for finding in report.complaints],
    }
    steps = stages(model.scenario) if model.scenario.first else (model,)
    backend, handover, before = None, None, list[dict[str, Any]]()
    recording: Recording | None = None
    for index, step in enumerate(steps, 1):
        last = step is steps[-1]
        own = file if file is None or last else file.with_name(f"{file.stem}_{index}{file.suffix}")
        carried = None if own is None else carried_files(step.scenario)
        with Recorder(own, header | recorded_header(step.scenario), listener, attachments=carried) as recorder:
            mission = Mission(step, planner if last and step is model else None, recorder, handover)
            backend = SimulatedBackend(step, seed=seed, recorder=recorder, realtime=realtime, after=backend)
            try:
                mission.fly(backend, duration, on_progress)
            except KeyboardInterrupt:
                pass  # the recording's last mission message says so
            recording = recorder.recording()
        if "truth" not in recording or "estimate" not in recording:  # interrupted before the first tick
            break
        recording.summary = _with_steps(summarize(recording, step), before, step, last)
        handover = mission.handover
        if not mission.outcome[0]:
            break
    assert recording is not None, "there is one step at least"
    return recording


def _with_steps(summary: dict[str, Any], before: list[dict[str, Any]], step: Model, last: bool) -> dict[str, Any]:
    """A step's summary, with what came of those before it; a task that ends before its last step has not opened the door."""
    if not before and last:
        return summary
    flown = {"joint": step.door.section.hinge, "outcome": summary["outcome"], "reason": summary["reason"],
            "collisions": summary["collisions"]}  # fmt: skip
    summary = summary | {
        "collisions": summary["collisions"] + sum(each["collisions"] for each in before),
        "opened": summary["opened"] and last, "steps": [*before, flown],
    }  # fmt: skip
    before.append(flown)
    return summary


def prepare(scenario: Scenario) -> None:
    """Compile or load what flights of a scenario run: short ones, from the air and from the door, where plans are made."""
    for start in ("hover", "contact"):
        mission = scenario.mission.model_copy(update={"start": start})
        simulate(scenario.model_copy(update={"mission": mission}), _PREPARATION, force=True)


def checked(model: Model, force: bool, report: Report | None) -> Report | None:
    """The check's report of a task that flies; made here, with its warnings issued to the caller's caller, if there is none."""
    if force:
        return report
    if report is None:
        report = check(model)
        for finding in report.warnings:
            warnings.warn(f"doorman check: {finding.name}: {finding.message}", FeasibilityWarning, stacklevel=3)
    report.refuse()
    return report


def _file(given: str | os.PathLike[str]) -> Path:
    if not isinstance(given, (str, os.PathLike)) or not (file := Path(given)).name or file.is_dir():
        raise DoormanError("not a place to record to", field="path", given=given, allowed="path of an MCAP file")
    return file
