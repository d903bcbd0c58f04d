"""`doorman warmup`: compile ahead what flights and checks run, so that none of them waits for it."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from contextlib import nullcontext

import typer

from doorman.cli.simulated.planners_ahead import planners_ahead
from doorman.cli.task import load_task
from doorman.cli.terminal.display import warmup_progress
from doorman.compilation import CacheContent, KernelCounts, cache_content, kernel_counts
from doorman.control.estimation.estimator import Estimator
from doorman.control.state_converter import StateConverter
from doorman.cores import usable_cores
from doorman.exceptions import BackendError
from doorman.feasibility.swing.rehearsal import rehearse
from doorman.mission import Mission
from doorman.model import Model
from doorman.ocp.solvers.order import last_first
from doorman.planning.planner import Planner
from doorman.recording import Recorder
from doorman.resources import scenario_directory, shipped
from doorman.scenario import Scenario
from doorman.simulation import SimulatedBackend

_PERIODS = 2
"""Controller periods to simulate: the start, and one that moves on."""

_FLIGHT_PERIODS = 3
"""Planner periods to fly: a cold plan and warm ones."""


def warm_up(sources: Sequence[str], settings: Sequence[str], as_json: bool, vehicle: str | None = None) -> int:
    """Compile everything that planning, checking and flying some scenarios runs, and say what was done."""
    # Every kernel is run once the way it is used, so that it is compiled for the arguments that it will get. What the cache
    # holds already is only loaded. Where it holds nothing, a second process compiles the planners meanwhile; the two begin at
    # different ends and share what they compile by the cache.
    started, before = time.perf_counter(), kernel_counts()
    is_shared = cache_content().kernels == 0 and usable_cores() > 1
    names = list(sources or shipped(scenario_directory(), ".toml"))
    scenarios = [load_task(source, settings, vehicle) for source in names]
    with planners_ahead(names, settings, vehicle) if is_shared else nullcontext():
        with last_first() if is_shared else nullcontext():
            _run_steps(scenarios[::-1] if is_shared else scenarios, not as_json)
    now, content = kernel_counts(), cache_content()
    compiled, loaded = now.compiled - before.compiled, now.loaded - before.loaded
    counts = KernelCounts(content.kernels if is_shared else compiled, loaded)
    _report(counts, content, time.perf_counter() - started, as_json)
    return 0


def _run_steps(scenarios: Sequence[Scenario], shown: bool) -> None:
    """Every step for every scenario; what the second process begins with comes late."""
    models = [Model(scenario) for scenario in scenarios]
    with warmup_progress(len(models) * len(_STEPS), kernel_counts, shown=shown) as on_step:
        for name, step in _STEPS.items():
            for model in models:
                on_step(f"{model.scenario.name}: {name}")
                step(model)


def _model(model: Model) -> None:
    state = model.start_state
    model.constraints(state)
    model.constraint_jacobian(state)
    model.constraints_along(state[None])


def _parts(model: Model) -> None:
    Estimator(model, StateConverter(model))
    try:
        with SimulatedBackend(model) as backend:
            for _ in range(_PERIODS):
                backend.read()
    except BackendError:
        pass  # MuJoCo is not installed, or cannot simulate this vehicle: then no flight needs its kernels


def _planner(model: Model) -> None:
    planner = Planner(model)
    planner.replan(planner.plan(planner.planning.start_state).states[1])


def _flight(model: Model) -> None:
    recorder = Recorder(None, {})
    mission = Mission(model, recorder=recorder)
    try:
        backend = SimulatedBackend(model, recorder=recorder)
        mission.fly(backend, _FLIGHT_PERIODS / model.scenario.planner.rate)
    except BackendError:
        pass


def _rehearsal(model: Model) -> None:
    rehearse(model, 2.0 * model.scenario.planner.time_step)


_STEPS: dict[str, Callable[[Model], None]] = {
    "constraints": _model,
    "estimator and simulator": _parts,
    "planner": _planner,
    "flight": _flight,
    "check": _rehearsal,
}


def _report(counts: KernelCounts, cache: CacheContent, seconds: float, as_json: bool) -> None:
    if as_json:
        figures = {
            "compiled": counts.compiled,
            "loaded": counts.loaded,
            "seconds": round(seconds, 3),
            "cache_directory": str(cache.directory),
            "cache_kernels": cache.kernels,
            "cache_bytes": cache.size,
        }
        typer.echo(json.dumps(figures, indent=2))
        return
    done = f"{counts.compiled} kernels compiled" if counts.compiled else "Nothing to compile"
    held = f"{cache.kernels} kernels, {cache.size / 1e6:.1f} MB"
    typer.echo(f"{done}, {counts.loaded} loaded, in {seconds:.1f} s. The cache holds {held}: {cache.directory}")
