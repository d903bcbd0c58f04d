#!/usr/bin/env python3
"""Constraints for pip: the lowest versions that `pyproject.toml` declares, of what users install.

Tools of tests and documentation are at most those of `constraints.txt`: the newest may want more than the lowest versions.
Whatever else comes along is the newest that fits.
"""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TOOLS = ("docs", "test")
"""Extras that only developers install."""


def lowest(project: dict) -> dict[str, str]:
    """Lowest declared version by distribution; the higher one where two extras declare two."""
    extras = project["optional-dependencies"]
    found: dict[str, str] = {}
    for name, version in _bounds(project["dependencies"], *(extras[extra] for extra in extras if extra not in TOOLS)):
        found[name] = max(version, found.get(name, "0"), key=_numbers)
    return found


def tools(project: dict, constraints: str) -> dict[str, str]:
    """Versions of the tools that users do not install."""
    pinned = {
        _normalised(name): version for name, version in re.findall(r"^([\w.-]+)==(\S+)", constraints, re.MULTILINE)
    }
    extras = project["optional-dependencies"]
    names = {name for name, _ in _bounds(*(extras[extra] for extra in TOOLS))} - set(lowest(project))
    return {name: pinned[name] for name in sorted(names)}


def _bounds(*lists: list[str]) -> list[tuple[str, str]]:
    """Name and lowest version of every requirement."""
    found = []
    for requirement in (one for requirements in lists for one in requirements):
        parts = re.fullmatch(r"([\w.-]+)(?:\[[\w,]+\])?>=([\d.]+)", requirement)
        if parts is None:
            raise ValueError(f"not of the form name>=version: {requirement}")
        found.append((_normalised(parts[1]), parts[2]))
    return found


def _normalised(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _numbers(version: str) -> list[int]:
    return [int(part) for part in version.split(".")]


if __name__ == "__main__":
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    passed = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    for distribution, number in lowest(declared).items():
        print(f"{distribution}=={number}")
    for distribution, number in tools(declared, passed).items():
        print(f"{distribution}<={number}")
