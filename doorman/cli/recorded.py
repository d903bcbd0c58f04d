"""A recorded run: its file, and the model of the scenario that was flown."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from doorman.exceptions import RecordingError
from doorman.recording import Recording
from doorman.scenario import Scenario

_FILE = "recording.mcap"
_SCENARIO = "scenario.toml"


def recording_file(run: Path) -> Path:
    """The recording of a run.

    Args:
        run: Folder of the run, or the file itself.

    Returns:
        The file.

    Raises:
        RecordingError: if there is no such file, or the folder holds no recording or several.
    """
    if run.is_file():
        return run
    if not run.is_dir():
        raise RecordingError("no such run", given=str(run), allowed="a run's folder, or an MCAP file")
    if (run / _FILE).is_file():
        return run / _FILE
    found = sorted(run.glob("*.mcap"))
    if len(found) != 1:
        names = ", ".join(file.name for file in found) or "no MCAP file"
        raise RecordingError("not the folder of one run", file=run, given=names, allowed=f"{_FILE}, or one MCAP file")
    return found[0]


def recorded_scenario(recording: Recording, file: Path) -> Scenario:
    """The scenario that was flown, as the recording's header holds it.

    URDFs that do not ship with doorman are looked for where the `scenario.toml` beside the recording says.

    Args:
        recording: The recording.
        file: Where it was read from.

    Returns:
        The scenario.

    Raises:
        RecordingError: if the header holds no scenario, or one that this version of doorman does not know.
        ScenarioError: if the `scenario.toml` beside the recording cannot be read.
    """
    tables: Any = recording.header.get("scenario")
    if not isinstance(tables, dict):
        raise RecordingError("the recording does not say which scenario was flown", file=file, field="header.scenario")
    tables = dict(tables)
    if (file.parent / _SCENARIO).is_file():
        beside = Scenario.load(file.parent / _SCENARIO)
        for section, urdf in (("vehicle", beside.vehicle.urdf), ("door", beside.door.urdf)):
            tables[section] = {**tables.get(section, {}), "urdf": urdf}
    try:
        return Scenario.model_validate(tables)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        raise RecordingError(
            "the recorded scenario does not fit this version of doorman", file=file,
            field=".".join(map(str, ("header", "scenario", *first["loc"]))), given=first["input"], allowed=first["msg"],
        ) from None  # fmt: skip
