"""Orders: everything that a flight depends on, as any process on any machine can carry it out."""

from __future__ import annotations

import base64
import hashlib
import importlib.metadata
import platform
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import doorman
from doorman.campaign.specification import Flight
from doorman.exceptions import DoormanError
from doorman.scenario import Scenario

_SECTIONS = ("vehicle", "door")
_ENGINES = ("numpy", "numba", "mujoco", "pin", "coal", "proxsuite")


class OtherSoftware(DoormanError):
    """An order is for another version of doorman or of what it computes with, or came with other files."""


def order_of(flight: Flight, files: Mapping[str, bytes]) -> dict[str, Any]:
    """The order for a flight, without its files: scenario, seed, versions, and the files' digests. For JSON."""
    return {
        "run": flight.draw.run,
        "seed": flight.draw.seed,
        "duration": flight.duration,
        "scenario": flight.scenario.portable(mode="json"),
        "files": digests(files),
        "software": software(),
    }


def packed(files: Mapping[str, bytes]) -> dict[str, str]:
    """Files as texts that JSON can hold, by name."""
    return {name: base64.b64encode(content).decode() for name, content in files.items()}


def digests(files: Mapping[str, bytes]) -> dict[str, str]:
    """Digests of files by name."""
    return {name: hashlib.sha256(content).hexdigest()[:16] for name, content in sorted(files.items())}


def check_software(order: Mapping[str, Any]) -> None:
    """Compare what an order was made with and what would fly it."""
    found = differences(order["software"])
    if found:
        raise OtherSoftware(f"the worker has other software than the campaign: {found}")


def unpacked(order: Mapping[str, Any], files: Mapping[str, str], folder: Path) -> Scenario:
    """The scenario of an order, with its files written to a folder."""
    contents = {Path(name).name: base64.b64decode(content) for name, content in files.items()}
    if digests(contents) != order["files"]:
        raise OtherSoftware("the worker was sent other files than the campaign's URDFs and meshes")
    for name, content in contents.items():
        path = folder / name
        if not path.is_file() or path.read_bytes() != content:
            path.write_bytes(content)
    tables = dict(order["scenario"])
    for section in _SECTIONS:
        tables[section] = {**tables[section], "urdf": str(folder / f"{section}.urdf")}
    return Scenario.model_validate(tables)


@cache
def software() -> dict[str, str]:
    """Versions by name, `doorman` with a digest of its sources among them."""
    package = Path(doorman.__file__).parent
    sources = sorted(package.rglob("*.py"))
    code = hashlib.sha256(b"".join(path.read_bytes() for path in sources if "visualization" not in path.parts))
    return {
        "doorman": f"{doorman.__version__} {code.hexdigest()[:16]}",
        **{name: importlib.metadata.version(name) for name in _ENGINES},
        "python": platform.python_version(),
        "machine": platform.machine(),
    }


def differences(theirs: dict[str, str]) -> str:
    """Where another process's software differs from this one's, in words; empty where it does not."""
    mine = software()
    names = [name for name in {**mine, **theirs} if mine.get(name) != theirs.get(name)]
    return ", ".join(f"{name} {mine.get(name, 'missing')} instead of {theirs.get(name, 'none')}" for name in names)
