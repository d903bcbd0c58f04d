"""A whole flight in simulation, recorded and summarised."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

from doorman.exceptions import DoormanError
from doorman.feasibility import FeasibilityWarning, Report, check
from doorman.mission.mission import Mission, OnProgress
from doorman.model import Model
from doorman.ocp.planner import Planner
from doorman.recording import Listener, Recorder, Recording
from doorman.scenario import Scenario
from doorman.summary import summarize


def simulate(
    scenario: Scenario | Model,
    duration: float | None = None,
    seed: int = 0,
    *,
    path: Path | None = None,
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
        scenario: The scenario, or a model of it that exists already.
        duration: Simulated time at most, > 0 [s]; to the mission's end if not given.
        seed: Of the sensors' noise and the gusts, >= 0.
        path: MCAP file to record to; in memory only if not given.
        realtime: Do not run ahead of the wall clock.
        planner: Planner of the same scenario, to save its construction.
        on_progress: Called once per planner period with time and estimated door angle.
        listener: Called with topic, time and fields of everything that is recorded, as it is recorded.
        force: Fly even what the check refuses; without a report, nothing is checked.
        report: Of the check, where it was made before; else it is made here, which takes less than a second.

    Returns:
        The recording, with its summary. After Ctrl-C it holds what was flown until then.

    Raises:
        InfeasibleError: if the check refuses the scenario; nothing is flown.
        DoormanError: if the scenario is unusable or the simulation fails.
    """
    from doorman import __version__
    from doorman.simulation import SimulatedBackend  # needs the extra `sim`

    if duration is not None and not 0.0 < duration < math.inf:
        raise DoormanError("not a duration", field="duration", given=duration, allowed="> 0 s")
    if seed < 0:
        raise DoormanError("not a seed", field="seed", given=seed, allowed=">= 0")
    model = scenario if isinstance(scenario, Model) else Model(scenario)
    if report is None and not force:
        report = check(model)
        for finding in report.warnings:
            warnings.warn(f"doorman check: {finding.name}: {finding.message}", FeasibilityWarning, stacklevel=2)
    if report is not None and not force:
        report.refuse()
    header = {
        "scenario": model.scenario.model_dump(mode="json"),
        "name": model.scenario.name,
        "seed": seed,
        "duration": duration,
        "version": __version__,
        "forced": force,
        "findings": None if report is None else [finding.as_dict() for finding in report.complaints],
    }
    with Recorder(path, header, listener) as recorder:
        mission = Mission(model, planner, recorder)
        backend = SimulatedBackend(model, seed=seed, recorder=recorder, realtime=realtime)
        try:
            mission.fly(backend, duration, on_progress)
        except KeyboardInterrupt:
            pass  # the recording's last mission message says so
        recording = recorder.recording()
    if "truth" in recording and "estimate" in recording:  # else interrupted before the first tick
        recording.summary = summarize(recording, model)
    return recording
