"""Folder of a campaign: what it holds, whose it is, and that one campaign at a time writes to it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from doorman.bounds import read_json
from doorman.campaign.flights.orders import digests, software
from doorman.campaign.specification import Campaign
from doorman.compilation.cache_files import write_atomically
from doorman.exceptions import DoormanError
from doorman.flown import carried_files
from doorman.locks import alone_in
from doorman.recording.files.disk import sync_folder

RESULTS = "results.parquet"
"""All rows."""
NOT_FLOWN = "not_flown.json"
"""Runs that machine or software kept from being flown, with the reasons."""
_IDENTITY = "campaign.json"
_PARTS = "runs"


@contextmanager
def claimed(folder: Path, campaign: Campaign) -> Iterator[Path]:
    """The folder, made if need be, for one campaign alone."""
    parts = folder / _PARTS
    parts.mkdir(parents=True, exist_ok=True)
    with alone_in(folder, "another process runs a campaign in this folder"):
        _check_identity(folder / _IDENTITY, identity(campaign))
        yield parts


def identity(campaign: Campaign) -> dict[str, Any]:
    """What two runs of a campaign must have in common to be rows of one table, for JSON."""
    scenario = campaign.scenario
    tables = scenario.portable(mode="json")
    for key in ("runs", "time_out"):
        del tables["campaign"][key]
    urdfs = digests(carried_files(scenario))
    versions = dict(software())
    return {"scenario": tables, "urdfs": urdfs, "doorman": versions.pop("doorman"), "versions": versions}


def write_not_flown(reasons: Mapping[int, str], folder: Path) -> None:
    """Note the runs that did not come about, and why; no file if there are none."""
    path = folder / NOT_FLOWN
    if reasons:
        write_atomically(path, (json.dumps(reasons, indent=2) + "\n").encode())
    else:
        path.unlink(missing_ok=True)


def read_not_flown(folder: Path) -> dict[int, str]:
    """Runs that did not come about when the campaign was last run, and why."""
    path = folder / NOT_FLOWN
    reasons = read_json(path) if path.is_file() else {}
    return {int(run): str(why) for run, why in reasons.items() if run.isascii() and run.isdigit()}


def _check_identity(path: Path, mine: dict[str, Any]) -> None:
    text = json.dumps(mine, indent=2)
    if not path.exists():
        write_atomically(path, f"{text}\n".encode())
        sync_folder(path.parent)
        return
    theirs = read_json(path)
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
