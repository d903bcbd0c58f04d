"""`doorman warmup`: compile ahead what flights and checks run, so that none of them waits for it."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from typing import TYPE_CHECKING

from doorman.cli.command import PREPARE, command
from doorman.cli.options import Json, Settings, Sources, Vehicle
from doorman.resources import own_process

if TYPE_CHECKING:  # commands import what they run when they run it
    from doorman.model import Model


@command(PREPARE)
def warmup(scenarios: Sources = None, settings: Settings = None, vehicle: Vehicle = None, as_json: Json = False) -> int:
    """Compile all kernels in advance, so that planner, check and flight start without delay.

    The command compiles the kernels of planner, dynamics, constraints, controller and simulator, for the number of joints of the
    scenarios' arms. A cache on disk keeps them until doorman, Numba or Python changes. An arm with another number of joints needs
    another warm-up.

    The last line shows the number of compiled kernels, the time, and the directory of the cache. The environment variable
    NUMBA_CACHE_DIR changes this directory. doorman removes kernels of other versions after a week without use, and beyond four
    versions after a day.
    """
    # Every kernel is run once the way it is used, so that it is compiled for the arguments that it will get. What the cache
    # holds already is only loaded. Where it holds nothing, a second process compiles the planners meanwhile; the two begin at
    # different ends and share what they compile by the cache.
    from doorman.cli.task import load_task
    from doorman.cli.terminal.display import print_result
    from doorman.compilation import cache_content, kernel_counts
    from doorman.cores import usable_cores
    from doorman.model import Model
    from doorman.ocp.solvers.order import last_first
    from doorman.resources import scenario_directory, shipped

    started, before = time.perf_counter(), kernel_counts()
    is_shared = cache_content().kernels == 0 and usable_cores() > 1
    names = list(scenarios or shipped(scenario_directory(), ".toml"))
    tasks = [load_task(source, settings, vehicle) for source in names]
    with planners_ahead(names, settings or (), vehicle) if is_shared else nullcontext():
        with last_first() if is_shared else nullcontext():
            _run_steps(list(map(Model, tasks[::-1] if is_shared else tasks)), not as_json)
    now, cache = kernel_counts(), cache_content()
    compiled, loaded = cache.kernels if is_shared else now.compiled - before.compiled, now.loaded - before.loaded
    seconds = time.perf_counter() - started
    done = f"{compiled} kernels compiled" if compiled else "Nothing to compile"
    held = f"{cache.kernels} kernels, {cache.size / 1e6:.1f} MB"
    figures = {
        "compiled": compiled, "loaded": loaded, "seconds": round(seconds, 3), "cache_directory": str(cache.directory),
        "cache_kernels": cache.kernels, "cache_bytes": cache.size,
    }  # fmt: skip
    words = f"{done}, {loaded} loaded, in {seconds:.1f} s. The cache holds {held}: {cache.directory}"
    print_result(as_json, figures, [words])
    return 0


def _run_steps(models: Sequence[Model], shown: bool) -> None:
    """Every step for every scenario; what the second process begins with comes late."""
    from doorman.cli.terminal.display import warmup_progress
    from doorman.compilation import kernel_counts

    with warmup_progress(len(models) * len(_STEPS), kernel_counts, shown=shown) as on_step:
        for name, step in _STEPS.items():
            for model in models:
                on_step(f"{model.scenario.name}: {name}")
                step(model)


def _flight(model: Model) -> None:
    from doorman.control.estimation.estimator import Estimator
    from doorman.control.state_converter import StateConverter
    from doorman.exceptions import BackendError
    from doorman.mission.simulate import prepare

    StateConverter(model)
    Estimator(model)
    with suppress(
        BackendError
    ):  # without MuJoCo, or for a vehicle that it cannot simulate, no flight needs its kernels
        prepare(model.scenario)


def _check(model: Model) -> None:
    from doorman.feasibility.swing.rehearsal import rehearse

    state = model.start_state
    model.constraints(state)
    model.constraint_jacobian(state)
    model.constraints_along(state[None])
    rehearse(model, 2.0 * model.scenario.planner.time_step)


_STEPS: dict[str, Callable[[Model], None]] = {"flight": _flight, "check": _check}


@contextmanager
def planners_ahead(
    sources: Sequence[str], settings: Sequence[str], vehicle: str | None
) -> Iterator[subprocess.Popen[bytes]]:
    """Have another process compile the planners of some scenarios into the cache; it ends with the block at the latest."""
    # What it cannot do, the first process will: that one reports whatever goes wrong.
    task = json.dumps([list(sources), list(settings), vehicle])
    process = subprocess.Popen(
        [sys.executable, "-c", f"from {__name__} import compile_planners; compile_planners()", task],
        env=own_process(), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.kill()  # what it has compiled by now is in the cache, and files there are whole or not at all
        process.wait()


def compile_planners() -> None:
    """Compile the planners that the process is started for."""
    from doorman.cli.task import load_task
    from doorman.planning.planner import Planner

    sources, settings, vehicle = json.loads(sys.argv[1])
    for source in sources:
        Planner(load_task(source, settings, vehicle))
