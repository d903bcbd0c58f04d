"""What is shipped: the wheel's files and its declared dependencies."""

from __future__ import annotations

import ast
import importlib.metadata
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import pytest
from hatchling.builders.wheel import WheelBuilder

import doorman

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    return Path(next(WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])))


@pytest.fixture(scope="module")
def unpacked(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    return folder


def files_below(folder: Path, suffix: str) -> set[str]:
    found = (path for path in folder.rglob(f"*{suffix}") if path.is_file() and "__pycache__" not in path.parts)
    return {str(path.relative_to(folder)) for path in found}


def run_python(code: str, folder: Path, **environment: str) -> str:
    """Run code in a fresh interpreter that finds doorman in `folder` and nowhere else."""
    ran = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, env={**os.environ, "PYTHONPATH": str(folder), **environment},
        capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    return ran.stdout.strip()


@pytest.mark.parametrize(
    ("source", "packaged", "suffix"),
    [
        ("doorman", "doorman", ""),
        ("doorman/scenarios", "doorman/scenarios", ".toml"),
        ("doorman/vehicles", "doorman/vehicles", ".toml"),
        ("urdf", "doorman/urdf", ".urdf"),
    ],
)
def test_the_wheel_holds_every_file(unpacked, source, packaged, suffix):
    expected = files_below(ROOT / source, suffix)
    assert expected
    assert expected <= files_below(unpacked / packaged, suffix)


def test_the_wheel_holds_the_package_alone(unpacked):
    assert (unpacked / "doorman" / "py.typed").is_file()
    assert {path.name for path in unpacked.iterdir()} == {"doorman", f"doorman_uam-{doorman.__version__}.dist-info"}
    information = unpacked / f"doorman_uam-{doorman.__version__}.dist-info"
    assert "doorman = doorman.cli:main" in (information / "entry_points.txt").read_text()
    assert list(information.rglob("LICENSE"))


def test_an_installed_doorman_finds_its_own_urdfs_and_scenarios(unpacked):
    code = "import doorman; s = doorman.Scenario.load('push'); print(s.source, s.vehicle_urdf, s.door_urdf, sep='\\n')"
    for line in run_python(code, unpacked).splitlines():
        assert Path(line).is_relative_to(unpacked / "doorman"), line
        assert Path(line).is_file()


def test_without_extras_the_models_and_the_planner_work(unpacked):
    code = "import sys\nfor name in ('mujoco', 'matplotlib', 'meshcat', 'casadi'): sys.modules[name] = None\n"
    code += "import doorman; print(len(doorman.Model(doorman.Scenario.load('paper')).start_state))"
    assert run_python(code, unpacked) == "9"


# ---------------------------------------------------------------- dependencies


def requirements(*extras: str) -> dict[str, str]:
    """Requirement by normalised name of distribution."""
    lists = [PROJECT["dependencies"], *(PROJECT["optional-dependencies"][extra] for extra in extras)]
    return {_normalised(re.split(r"[<>=!~\[; ]", text)[0]): text for texts in lists for text in texts}


def _normalised(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def third_party_imports(path: Path) -> set[str]:
    """Top names of everything a file imports that is neither doorman's nor Python's."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and node.level == 0:
            names.add(node.module.partition(".")[0])
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("import_module", "find_spec")):
            names |= {arg.value.partition(".")[0] for arg in node.args if isinstance(arg, ast.Constant)}
    return {name for name in names if name not in sys.stdlib_module_names and name not in ("doorman", "__future__")}


PROVIDED_BY = {"distributed": "dask", "pinocchio": "pin", "yaml": "pyyaml"} | {
    name: name for name in ("coal", "proxsuite", "mujoco")
}
"""Distributions whose metadata does not name the modules they install where Python looks for them."""


@cache
def installed_modules() -> Mapping[str, list[str]]:
    return importlib.metadata.packages_distributions()


def distribution_of(module: str) -> str:
    return PROVIDED_BY.get(module) or _normalised(installed_modules()[module][0])


def test_every_import_is_a_declared_dependency():
    extras = {
        "simulation": ("sim",), "visualization": ("viz",), "hardware": ("hardware", "mocap", "tags"), "campaign": ("campaign",),
        "feasibility": ("sim",), "recording": ("campaign", "pandas"), "rig": ("sim", "hardware"),
        "ros2": ("ros2",), "learning": ("gym",), "flight": ("hardware",), "kinematics": ("xacro",), "door_sensor": ("tags",),
    }  # fmt: skip
    for path in (ROOT / "doorman").rglob("*.py"):
        declared = requirements(*extras.get(path.relative_to(ROOT / "doorman").parts[0], ()))
        for module in third_party_imports(path):
            assert distribution_of(module) in declared, f"{path} imports {module}"
    declared = requirements("sim", "viz", "hardware", "campaign", "docs", "test")
    own = {path.stem for path in (ROOT / "tests").rglob("*.py")} | {"suite", "build_native"}  # of benchmarks/
    for path in (ROOT / "tests").rglob("*.py"):
        for module in third_party_imports(path) - own:
            assert distribution_of(module) in declared, f"{path} imports {module}"


def test_every_dependency_is_imported():
    tests = [*(ROOT / "tests").rglob("*.py")]
    own = {test.stem for test in tests} | {"suite", "build_native"}  # of benchmarks/
    modules = set().union(*map(third_party_imports, [*(ROOT / "doorman").rglob("*.py"), *tests]))
    imported = {distribution_of(module) for module in modules - own}
    checks = {"pytest-cov", "pytest-xdist", "ruff", "mypy", "import-linter", "example-robot-data"}
    tools = checks | {"myst-parser", "myst-nb", "furo"}
    assert set(requirements("sim", "viz", "hardware", "campaign", "docs", "test")) - tools <= imported


@pytest.mark.parametrize("requirement", requirements("sim", "viz", "hardware", "campaign", "docs", "test").values())
def test_every_dependency_has_a_lower_bound_that_is_met(requirement):
    name, bound = re.fullmatch(r"([\w.-]+)(?:\[\w+\])?>=([\d.]+)", requirement).groups()
    installed = importlib.metadata.version(name)
    assert [int(part) for part in re.findall(r"\d+", installed)] >= [int(part) for part in bound.split(".")]
