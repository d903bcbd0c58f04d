"""Folder of a campaign: what it holds, whose it is, and that one campaign at a time writes to it."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import platform
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import doorman
from doorman.campaign.specification import Campaign, portable
from doorman.exceptions import DoormanError
from doorman.locks import locked

RESULTS = "results.parquet"
"""All rows."""
_IDENTITY = "campaign.json"
_PARTS = "runs"
_LOCK = ".lock"
_ENGINES = ("numpy", "numba", "mujoco", "pin", "coal", "proxsuite")
"""Packages whose version decides about the last bit of a flight."""


@contextmanager
def claimed(folder: Path, campaign: Campaign) -> Iterator[Path]:
    """The folder, made if need be, for one campaign alone.

    Args:
        folder: The campaign's folder; what an earlier run of the same campaign has left there is kept.
        campaign: The campaign.

    Yields:
        Folder of the parts.

    Raises:
        DoormanError: if it belongs to another campaign, or another process writes to it now.
    """
    parts = folder / _PARTS
    parts.mkdir(parents=True, exist_ok=True)
    with ExitStack() as stack:
        try:
            stack.enter_context(locked(folder / _LOCK))
        except BlockingIOError as error:
            raise DoormanError(
                "another process runs a campaign in this folder", field="--out", given=str(folder)
            ) from error
        _check_identity(folder / _IDENTITY, identity(campaign))
        yield parts


def identity(campaign: Campaign) -> dict[str, Any]:
    """What two runs of a campaign must have in common to be rows of one table."""
    scenario = campaign.scenario
    tables = portable(scenario)
    for key in ("runs", "time_out", "low_friction"):
        del tables["campaign"][key]
    urdfs = {path.name: _digest(path) for path in (scenario.vehicle_urdf, scenario.door_urdf)}
    package = Path(doorman.__file__).parent
    sources = sorted(package.rglob("*.py"))
    code = hashlib.sha256(b"".join(path.read_bytes() for path in sources if "visualization" not in path.parts))
    versions = {name: importlib.metadata.version(name) for name in _ENGINES}
    return {
        "scenario": tables,
        "urdfs": urdfs,
        "doorman": f"{doorman.__version__} {code.hexdigest()[:16]}",
        "versions": versions | {"python": platform.python_version(), "machine": platform.machine()},
    }


def _check_identity(path: Path, mine: dict[str, Any]) -> None:
    text = json.dumps(mine, indent=2)
    if not path.exists():
        unfinished = path.with_suffix(".unfinished")
        unfinished.write_text(text + "\n", encoding="utf-8")
        unfinished.replace(path)
        return
    theirs = json.loads(path.read_text(encoding="utf-8"))
    differing = sorted(_differences(theirs, json.loads(text), ""))
    if differing:
        raise DoormanError(
            "the folder holds another campaign", file=path, field="--out", given=f"different: {', '.join(differing)}",
            allowed="a new folder, or the campaign that began there",
        )  # fmt: skip


def _differences(one: Any, other: Any, name: str) -> Iterator[str]:
    if isinstance(one, dict) and isinstance(other, dict):
        for key in one.keys() | other.keys():
            yield from _differences(one.get(key), other.get(key), f"{name}.{key}" if name else key)
    elif one != other:
        yield name


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]
