"""What was flown: what a recording says of its scenario, and the scenario made of that again, on any machine."""

from __future__ import annotations

import hashlib
import tempfile
import warnings
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from doorman.bounds import check_tables
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.exceptions import RecordingError
from doorman.kinematics.urdf.mesh_files import portable_files
from doorman.model import Model
from doorman.recording import Recording
from doorman.scenario import Scenario
from doorman.summary import summarize

_PARTS = ("vehicle", "door")
"""Sections of a scenario that name a URDF."""
_BESIDE = "scenario.toml"


def recorded_header(scenario: Scenario) -> dict[str, Any]:
    """Header of every recording: the scenario with its values, and its name."""
    return {"scenario": scenario.tables(mode="json"), "name": scenario.name}


def carried_files(scenario: Scenario) -> dict[str, bytes]:
    """The files that a recording carries, by name: `vehicle.urdf`, `door.urdf`, and their meshes."""
    return portable_files(scenario.vehicle_urdf, "vehicle") | portable_files(scenario.door_urdf, "door")


def recorded_scenario(
    recording: Recording, folder: Path | None = None, warn: Callable[[str], None] = warnings.warn
) -> Scenario:
    """The scenario that was flown; keys that this version of doorman does not know are left out with a warning."""
    # A recording that carries no URDFs has them looked for where the `scenario.toml` beside it says.
    tables = recording.header.get("scenario")
    if not isinstance(tables, dict):
        raise RecordingError(
            "the recording does not say which scenario was flown", file=folder, field="header.scenario"
        )
    urdfs = _urdfs(recording, folder)
    for part, urdf in urdfs.items():
        table = tables.get(part)
        tables = tables | {part: {**(table if isinstance(table, dict) else {}), "urdf": urdf}}
    scenario, unknown = _validated(tables, folder)
    if unknown:
        warn(f"another version of doorman made the recording; ignored: {', '.join(unknown)}")
    return scenario


def recorded_loop(recording: Recording) -> AttitudeLoop | None:
    """Attitude loop that a flight measured in its hover, the mean of both axes; None if it measured none."""
    if "attitude_loop" not in recording:
        return None
    found = recording["attitude_loop"]
    return AttitudeLoop(float(found["lag"][-1].mean()), float(found["dead_time"][-1].mean()))


def summary_of(recording: Recording) -> dict[str, Any]:
    """Figures of a simulated run, the keys of `summary.json`, by the scenario that it has recorded."""
    return summarize(recording, Model(recorded_scenario(recording)))


def _urdfs(recording: Recording, folder: Path | None) -> dict[str, str]:
    """Where the URDFs of this recording are now, as far as it is known, by section."""
    carried = {part: name for part in _PARTS if (name := f"{part}.urdf") in recording.attachments}
    if carried:
        unpacked = _unpacked(recording.attachments)
        return {part: str(unpacked / name) for part, name in carried.items()}
    if folder is None or not (folder / _BESIDE).is_file():
        return {}
    beside = Scenario.load(folder / _BESIDE)
    return {"vehicle": str(beside.vehicle_urdf), "door": str(beside.door_urdf)}


def _validated(tables: dict[str, Any], folder: Path | None) -> tuple[Scenario, list[str]]:
    """The scenario, and the keys that had to be left out."""
    unknown: list[str] = []
    check_tables(tables, RecordingError, folder)
    while True:
        try:
            return Scenario.model_validate(tables), unknown
        except ValidationError as error:
            found = error.errors(include_url=False)
            extra = [tuple(map(str, one["loc"])) for one in found if one["type"] == "extra_forbidden"]
            shorter = tables
            for keys in extra:
                shorter = _without(shorter, keys)
            if not extra or shorter == tables:
                where = ".".join(map(str, ("header", "scenario", *found[0]["loc"])))
                raise RecordingError(
                    "the recorded scenario does not fit this version of doorman", file=folder, field=where,
                    given=found[0]["input"], allowed=found[0]["msg"],
                ) from None  # fmt: skip
            tables = shorter
            unknown += [".".join(keys) for keys in extra]


def _without(table: Any, keys: tuple[str, ...]) -> Any:
    """The table without a key of it, or of a table in it."""
    first, *rest = keys
    if not isinstance(table, dict) or first not in table:
        return table
    if not rest:
        return {key: value for key, value in table.items() if key != first}
    return {**table, first: _without(table[first], tuple(rest))}


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """Goes with the process."""
    return tempfile.TemporaryDirectory(prefix="doorman-recorded-")


def _unpacked(files: Mapping[str, bytes]) -> Path:
    """A folder with the files, the same for the same ones; their names may be anybody's, and do not lead out of it."""
    digest = hashlib.sha256()
    for name, data in sorted(files.items()):
        digest.update(f"{len(name)} {name} {len(data)} ".encode())
        digest.update(data)
    folder = Path(_folder().name) / digest.hexdigest()[:16]
    if not folder.is_dir():
        folder.mkdir()
        for name, data in files.items():
            if name == Path(name).name and name not in ("", ".", ".."):
                (folder / name).write_bytes(data)
    return folder
