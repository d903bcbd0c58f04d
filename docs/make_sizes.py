"""Writes the table of extras in docs/installation.md: what each adds, measured on the packages that are installed here.

Usage: python docs/make_sizes.py, in an environment with all extras.
"""

from __future__ import annotations

import importlib.metadata as metadata
import re
import tomllib
from functools import cache
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "installation.md"
HEAD = "| extra | MB | packages | what |\n| --- | --- | --- | --- |\n"
TABLE = re.compile(r"^\| extra \| MB \| packages \| what \|\n(?:^\|.*\n)+", re.MULTILINE)
WHAT = {
    "sim": "MuJoCo",
    "viz": "matplotlib, meshcat",
    "hardware": "pymavlink, serial ports, servos",
    "mocap": "cameras' clients",
    "ros2": "Cyclone DDS",
    "tags": "OpenCV, which reads cameras and finds tags",
    "xacro": "xacro",
    "gym": "Gymnasium, and MuJoCo",
    "pandas": "pandas",
    "learn": "Stable-Baselines3 with PyTorch for processors, Gymnasium, MuJoCo, matplotlib",
    "campaign": "Dask, PyArrow, matplotlib",
    "docs": "Sphinx and the notebooks' kernel",
    "test": "pytest, mypy, the tools above, and what the tests compare with",
}


@cache
def closure(requirement: str) -> frozenset[str]:
    """Distributions that a requirement brings in, by normalised name."""
    found: set[str] = set()
    waiting = [Requirement(requirement)]
    while waiting:
        wanted = waiting.pop()
        name = re.sub(r"[-_.]+", "-", wanted.name).lower()
        new = f"{name}[{','.join(sorted(wanted.extras))}]"
        if new in found:
            continue
        found.add(new)
        for text in metadata.requires(wanted.name) or []:
            one = Requirement(text)
            if one.marker is None or any(one.marker.evaluate({"extra": extra}) for extra in ("", *wanted.extras)):
                waiting.append(one)
    return frozenset(each.partition("[")[0] for each in found)


@cache
def megabytes(name: str) -> float:
    """Size of a distribution's files without compiled bytecode."""
    paths = {Path(str(file.locate())).resolve() for file in metadata.files(name) or [] if file.suffix != ".pyc"}
    return sum(path.stat().st_size for path in paths if path.is_file()) / 1e6


def page(text: str) -> str:
    """The page with its table made anew.

    Args:
        text: The page as it is.
    """
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    base = frozenset().union(*map(closure, project["dependencies"]))
    rows = f"| none | {sum(map(megabytes, base)):.0f} | {len(base)} | planner, models, controller, command line |\n"
    everything = set(base)
    for extra, requirements in project["optional-dependencies"].items():
        added = frozenset().union(*map(closure, requirements)) - base
        everything |= added
        rows += f"| `{extra}` | {sum(map(megabytes, added)):.0f} | {len(added)} | {WHAT[extra]} |\n"
    rows += f"| all of them | {sum(map(megabytes, everything)):.0f} | {len(everything)} | |\n"
    return TABLE.sub(lambda _: HEAD + rows, text)


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
