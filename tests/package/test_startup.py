"""What a fresh process loads and compiles: no more than what was asked for."""

from __future__ import annotations

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import doorman

ROOT = Path(__file__).parents[2]

PLAN = """
from doorman import Planner, Scenario
planner = Planner(Scenario.load("paper"))
assert planner.plan(planner.model.start_state).usable
"""
COMMAND = """
from doorman.cli import main
sys.argv = ["doorman", *{arguments}]
try:
    main()
except SystemExit as end:
    assert end.code == 0, end.code
"""
LOADED = "import sys{code}\nprint()\nprint(*(name for name in {names} if name in sys.modules))"
COMPILED = """
import json, sys
from numba.core import event
from doorman.compilation import kernel_counts
listener = event.RecordingListener()
event.register("numba:compile", listener)
{code}
compiled = [str(begun.data["dispatcher"]) for _, begun in listener.buffer if begun.is_start]
print()
counts = kernel_counts()
print(json.dumps({{"compiled": compiled, "counted": counts.compiled, "loaded": counts.loaded, "modules": sorted(sys.modules)}}))
"""
FLIGHT = """
from pathlib import Path
from doorman.cli.simulated.open_door import open_door
open_door("paper", out=Path("run"), duration=0.1, as_json=True)
"""
CHECK = """
from doorman.cli.simulated.check import check
assert check("paper", as_json=True) == 0
"""
WARMUP = """
from doorman.cli.simulated.warmup import warmup
assert warmup(["paper"], as_json=True) == 0
"""


def output(code: str, folder: Path, **environment: str) -> str:
    """What a program prints in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT), **environment},
        capture_output=True, text=True, timeout=900, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout


def loaded_by(code: str, names: set[str], folder: Path) -> set[str]:
    """Those of the modules that a program loads."""
    return set(output(LOADED.format(code=f"\n{code}", names=names), folder).splitlines()[-1].split())


# ---------------------------------------------------------------- imports


def test_the_package_loads_nothing_before_it_is_asked(tmp_path):
    names = {"numpy", "numba", "pinocchio", "pydantic", "doorman.exceptions", "doorman.model", "doorman.mission"}
    assert loaded_by("import doorman; doorman.__version__; dir(doorman)", names, tmp_path) == set()
    asked = loaded_by("import doorman; doorman.DoormanError", names, tmp_path)
    assert asked == {"doorman.exceptions"}
    assert loaded_by("from doorman import *; Model, simulate", names, tmp_path) == names


def test_every_public_name_is_that_of_its_module():
    assert set(doorman.__all__) <= set(dir(doorman))
    for name in doorman.__all__:
        value = getattr(doorman, name)
        assert getattr(importlib.import_module(value.__module__), name) is value
        assert vars(doorman)[name] is value


def test_packages_come_when_they_are_asked_for(tmp_path):
    code = "import doorman; assert doorman.ocp.Problem and doorman.scenario.Scenario; dir(doorman)"
    assert loaded_by(code, {"doorman.ocp.problem.problem", "doorman.mission", "mujoco"}, tmp_path) == {
        "doorman.ocp.problem.problem"
    }
    folders = {path.parent.name for path in (ROOT / "doorman").glob("*/__init__.py")}
    assert folders <= set(dir(doorman))
    for name in folders:
        assert getattr(doorman, name) is importlib.import_module(f"doorman.{name}")


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match=r"'doorman' has no attribute 'Plane'"):
        doorman.Plane  # noqa: B018
    with pytest.raises(ImportError, match="Plane"):
        exec("from doorman import Plane")
    assert not hasattr(doorman, "_MODULE")


def test_a_flight_and_its_page_load_neither_meshes_nor_plots(tmp_path):
    """Figures bring matplotlib in when they are drawn; nothing brings in what reads meshes."""
    page = FLIGHT.replace("open_door(", "open_door.__globals__.update(write_pictures=replay)\nopen_door(")
    code = f"""
from doorman.visualization.replay import replay_page
def replay(recording, model, folder, helper):
    replay_page(recording, model, folder / "replay.html")
{page}"""
    assert loaded_by(code, {*MESHES, "mujoco"}, tmp_path) == {"mujoco"}
    assert (tmp_path / "run" / "replay.html").is_file()


@pytest.mark.parametrize("arguments", [["--version"], ["open", "--help"]], ids=" ".join)
def test_help_and_version_load_no_numerics(arguments, tmp_path):
    numerics = {"numpy", "scipy", "numba", "pinocchio", "proxsuite", "mujoco", "matplotlib"}
    code = COMMAND.format(arguments=arguments)
    assert loaded_by(code, {*numerics, "doorman.cli.app"}, tmp_path) == {"doorman.cli.app"}


# ---------------------------------------------------------------- compilation


WARM_UP = "import sys" + COMMAND.format(arguments=["warmup", "paper", "--json"])


@pytest.mark.slow
def test_a_warm_up_fills_the_cache(tmp_path):
    figures = json.loads(output(WARM_UP, tmp_path, NUMBA_CACHE_DIR=str(tmp_path)))
    (directory,) = tmp_path.iterdir()
    kernels = list(directory.rglob("*-linked*.nbc"))
    entries = {*directory.rglob("*.nbc")} - {*kernels}
    assert figures["compiled"] > 0
    assert figures["cache_directory"] == str(directory)
    assert figures["cache_kernels"] == len(kernels) == figures["compiled"]
    assert 0 < len(entries) < len(kernels) / 3  # machine code of what Python calls only
    assert figures["cache_bytes"] > sum(kernel.stat().st_size for kernel in kernels) > 0


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> None:
    """The kernels are those of `doorman warmup paper`."""
    output(WARM_UP, tmp_path_factory.mktemp("warm"))


MESHES = {"yourdfpy", "trimesh", "networkx", "matplotlib", "meshcat"}
"""What reads them, and what draws: it would take longer than all that is computed."""


@pytest.mark.parametrize(
    ("code", "unused"),
    [
        (PLAN, {*MESHES, "fcl", "mujoco", "mcap", "typer", "rich", "doorman.ocp.solvers.cddp"}), (FLIGHT, set()),
        (CHECK, MESHES), (WARMUP, set()),
    ],
    ids=["plan", "flight", "check", "another warm-up"],
)  # fmt: skip
def test_after_a_warm_up_nothing_is_compiled_and_nothing_loaded_in_vain(code, unused, warm, tmp_path):
    printed = output(COMPILED.format(code=code), tmp_path)
    figures = json.loads(printed.splitlines()[-1])
    assert figures["compiled"] == []
    assert figures["counted"] == 0
    assert figures["loaded"] > 0
    assert unused.isdisjoint(figures["modules"])


def test_a_plan_from_the_cache_leaves_the_compiler_unloaded(warm, tmp_path):
    """Half a second of imports that only compiling needs."""
    names = {"numba.np.linalg", "numba.np.npyimpl", "numba.typed.typeddict", "numba.core.dispatcher"}
    printed = output(LOADED.format(code=f"\n{PLAN}", names=names), tmp_path)
    assert set(printed.splitlines()[-1].split()) == {"numba.core.dispatcher"}
