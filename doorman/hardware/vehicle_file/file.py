"""Vehicle file: read, checked, put over a scenario and into the links' configuration; and values written into it."""

from __future__ import annotations

import os
import tempfile
import tomllib
from collections.abc import Iterator, Mapping, MutableMapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import tomlkit
from pydantic import BaseModel, ValidationError

from doorman.exceptions import BackendError, DoormanError, ScenarioError
from doorman.hardware.computer.doctor import Complaint, Host, Row, device_row, judged
from doorman.hardware.pixhawk.wire.connection import Transport, parse_connection
from doorman.hardware.vehicle import VehicleConfig, vehicle_config
from doorman.hardware.vehicle_file.template import GAINS, TABLES, VEHICLE
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.scenario.errors import explain
from doorman.scenario.files import URDF, VEHICLE_FILE, absolute, locate, read_tables
from doorman.scenario.plain import plain
from doorman.scenario.values import Section

NO_CAMERAS = "none"
"""`mocap.connection` of a vehicle that flies by the autopilot's own estimate."""
PIXHAWK, SERVOS, MOCAP = "pixhawk.connection", "servos.port", "mocap.connection"
"""Keys of the three links."""
OPTIONS = {PIXHAWK: "--pixhawk", SERVOS: "--servos"}
"""Options that replace a key of the file."""
_PER_SERVO = ("servos.ids", "servos.directions", "servos.zero_positions", "servos.homing_offsets")
_ANYWHERE = MappingProxyType({PIXHAWK: "udp:14540", SERVOS: "/dev/servos"})


@dataclass(frozen=True)
class VehicleFile:
    """What a vehicle file says; without a file, nothing.

    Make one with `VehicleFile.load`.
    """

    path: Path | None = None
    """The file."""
    values: Mapping[str, Any] = field(default_factory=dict)
    """Every value that the file gives, by dotted key; paths are absolute."""

    @classmethod
    def load(cls, source: str | os.PathLike[str]) -> VehicleFile:
        """Read a vehicle file and check it.

        Args:
            source: Path of a TOML file, with its suffix, or name of a shipped one (`rig`).

        Returns:
            What it says.

        Raises:
            ScenarioError: if the file is missing or malformed, or a key is unknown, of wrong type or out of range.
        """
        text = plain(source)
        if not isinstance(text, str):
            raise ScenarioError("not a vehicle file", given=source, allowed="a name, or the path of a TOML file")
        path = locate(VEHICLE_FILE, text, [Path.cwd()]).resolve()
        try:
            tables = TABLES.model_validate(read_tables(path))
        except ValidationError as error:
            raise explain(TABLES, error, path) from None
        return cls(path, MappingProxyType(dict(_with_whole_paths(_leaves(tables, ""), path))))

    @property
    def scenario_values(self) -> dict[str, Any]:
        """Values that are a scenario's, by dotted key: what is left out of them is as the task has it."""
        return {key: value for key, value in self.values.items() if key.partition(".")[0] in (VEHICLE, *GAINS)}

    def scenario(
        self, source: str | os.PathLike[str] = "paper", overrides: Mapping[str, Any] | None = None
    ) -> Scenario:
        """A task as this vehicle flies it.

        A `[vehicle]` with a URDF takes the place of the scenario's. Any other value wins over the scenario's by itself.

        Args:
            source: As `Scenario.load`.
            overrides: As `Scenario.load`; they win over both.

        Returns:
            The scenario.

        Raises:
            ScenarioError: as `Scenario.load`.
        """
        return Scenario.load(source, {**self.scenario_values, **(overrides or {})})

    def links(self, model: Model, overrides: Mapping[str, object] | None = None) -> VehicleConfig:
        """Configuration of the links; a task without a gripper leaves the gripper's servo alone.

        Args:
            model: Model of the scenario that this vehicle flies.
            overrides: Values by dotted key of the links' tables, as the command line gives them; they win over the file.

        Returns:
            The configuration, with the loss of poses left to a supervisor.

        Raises:
            DoormanError: if a value is out of range, the links contradict each other, or a link is not named.
        """
        given, most = dict(overrides or {}), model.n_arm + 1
        own = {
            key: value for key, value in self.values.items()
            if key.partition(".")[0] not in (VEHICLE, *GAINS) and not any(_covers(one, key) for one in given)
        }  # fmt: skip
        if model.scenario.contact.kind != "grip":  # the gripper's servo is not used
            own |= {key: own[key][:-1] for key in _PER_SERVO if key in own and len(own[key]) == most}
        try:
            return self._links(model, own, dict(given))
        except DoormanError as error:
            first, _, rest = (error.field or "").partition(".")  # as the links name it, whose rate is `vehicle.rate`
            name = rest if first == VEHICLE else error.field or ""
            file = None if any(_covers(one, name) for one in given) else self.path
            raise type(error)(
                error.message, file=error.file or file, field=name or None, given=error.given, allowed=error.allowed
            ) from error

    def links_anywhere(self, model: Model) -> VehicleConfig:
        """Configuration of the links for what opens none of them: those that the file does not name are made up.

        Args:
            model: Model of the scenario that this vehicle flies.

        Raises:
            DoormanError: as `links`.
        """
        return self.links(model, {key: value for key, value in _ANYWHERE.items() if key not in self.values})

    def _links(self, model: Model, own: dict[str, Any], given: dict[str, Any]) -> VehicleConfig:
        cameras = given.pop(MOCAP, own.pop(MOCAP, None))
        if cameras is None and (keys := [key for key in own if key.startswith("mocap.")]):
            raise BackendError("cameras without a link", field=MOCAP, given=f"only {', '.join(keys)}",
                               allowed=f'such as "udp:51001", or "{NO_CAMERAS}"')  # fmt: skip
        if cameras in (None, NO_CAMERAS):
            cameras, own = None, {key: value for key, value in own.items() if not key.startswith("mocap.")}
        values = {**own, **given}
        if model.n_arm == 0 and model.scenario.contact.kind == "push":  # a stick has no servos
            values = {"servos.port": "", **values}
        for key, option in OPTIONS.items():
            if key not in values:
                allowed = f"in the vehicle file, or by {option}"
                raise BackendError("the link's address or device is missing", field=key, allowed=allowed)
        return vehicle_config(
            model, values.pop(PIXHAWK), values.pop(SERVOS), cameras, on_mocap_loss="report", links=values
        )


def _leaves(section: Section, prefix: str) -> Iterator[tuple[str, Any]]:
    """Values that were given, by dotted key; of a `[vehicle]` with a URDF all, since it replaces the scenario's."""
    whole = prefix == f"{VEHICLE}." and "urdf" in section.model_fields_set
    for name in type(section).model_fields if whole else sorted(section.model_fields_set):
        value = getattr(section, name)
        if isinstance(value, Section):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _with_whole_paths(leaves: Iterator[tuple[str, Any]], path: Path) -> Iterator[tuple[str, Any]]:
    """Values with paths that hold in any directory; a URDF that does not exist is an error of this file."""
    for key, value in leaves:
        if key == "vehicle.urdf":
            locate(URDF, value, list(dict.fromkeys((path.parent, Path.cwd()))), path, key)
            yield key, absolute(value, path.parent)
        else:
            yield key, path.parent / value if isinstance(value, Path) else value


def _covers(key: str, other: str) -> bool:
    """Whether a value of one key is, or holds, that of another, or the other way round."""
    return key == other or other.startswith(f"{key}.") or key.startswith(f"{other}.")


def write_values(path: Path, values: Mapping[str, object], tables: type[BaseModel] = TABLES) -> None:
    """Write values into a vehicle file, or a task; everything else in it stays, byte for byte.

    The file is replaced in one step, and only by one that can be read again.

    Args:
        path: The file.
        values: Values by dotted key; tables that are missing are added at the end.
        tables: What the file may hold: a vehicle file's tables, or a scenario's.

    Raises:
        ScenarioError: if the file is malformed or cannot be written, or a value does not fit its key.
    """
    read_tables(path)  # says what is wrong with it
    document = tomlkit.parse(path.read_text(encoding="utf-8-sig"))
    for key, value in values.items():
        _set(document, key, plain(value), path)
    text = tomlkit.dumps(document)
    try:
        tables.model_validate(tomllib.loads(text))
    except ValidationError as error:
        raise explain(tables, error, path) from None
    try:
        _replace(path, text)
    except OSError as error:
        raise ScenarioError(f"cannot be written: {error.strerror}", file=path) from error


def _set(document: MutableMapping[str, Any], key: str, value: object, path: Path) -> None:
    *sections, last = key.split(".")
    table: Any = document
    for section in sections:
        table = table.setdefault(section, {})
        if not isinstance(table, MutableMapping):
            raise ScenarioError("wrong value", file=path, field=section, given=table, allowed="a table")
    table[last] = value


def _replace(path: Path, text: str) -> None:
    """Write beside the file, then rename: no reader sees half a file."""
    target = path.resolve()
    descriptor, beside = tempfile.mkstemp(prefix=f".{target.name}.", dir=target.parent)
    try:
        with open(descriptor, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(beside, target.stat().st_mode & 0o7777)
        os.replace(beside, target)
    except BaseException:
        Path(beside).unlink(missing_ok=True)
        raise


_DEVICES = "doorman system udev | sudo tee /etc/udev/rules.d/99-doorman.rules"


def devices(host: Host, file: VehicleFile) -> list[Row]:
    rows, link = [], file.values.get(PIXHAWK)
    endpoint = None if link is None else parse_connection(link)
    serial = endpoint.device if endpoint is not None and endpoint.transport is Transport.SERIAL else None
    for key, device in (("pixhawk", serial), ("servos", file.values.get(SERVOS))):
        if device is not None and Path(device).exists():
            rows.append(device_row(host, f"{key}: {device}", Path(device), "found; "))
        elif device is not None:
            words = "not found; plug it in, or give it this name by a udev rule"
            rows.append(Row(f"{key}: {device}", Complaint.MISSING, words, _DEVICES))
    if (key_file := file.values.get("pixhawk.signing_key")) is not None:
        command = f"head -c 32 /dev/urandom > {key_file}"
        rows.append(judged("signing key", key_file.is_file(), "there", "not there", command, Complaint.MISSING))
    return rows
