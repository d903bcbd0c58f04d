"""`Scenario`: all sections of one task, read from TOML and checked."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import PrivateAttr, ValidationError, model_validator

from doorman.bounds import check_tables
from doorman.exceptions import ScenarioError
from doorman.scenario.dotted import put
from doorman.scenario.errors import explain
from doorman.scenario.files import SCENARIO, SHIPPED, URDF, absolute, locate, read_tables
from doorman.scenario.plain import plain
from doorman.scenario.sections.campaign import CampaignSection, Distribution
from doorman.scenario.sections.estimation import EstimationSection
from doorman.scenario.sections.first import FirstSection
from doorman.scenario.sections.laboratory import SafetySection
from doorman.scenario.sections.reality import RealitySection, under
from doorman.scenario.sections.simulation import SimulationSection
from doorman.scenario.sections.task import ContactSection, DoorSection, GoalSection, MissionSection, StartSection
from doorman.scenario.sections.vehicle import ControlSection, LimitsSection, PlannerSection, VehicleSection
from doorman.scenario.sized_keys import SIZED
from doorman.scenario.toml_text import toml_text
from doorman.scenario.values import Section, hashed

_URDFS = ("vehicle.urdf", "door.urdf")
"""Keys that hold the path of a file, or the name of a shipped one."""


class Scenario(Section):
    """One task: URDFs, contact, start, goal, and the options of planner, controller and simulator.

    Make one with `Scenario.load`; `Scenario()` is the paper's task. Two scenarios are equal if they have the same values and the
    same files, wherever they were read from.

    Raises:
        ScenarioError: if a key is unknown, or a value of wrong type or out of range.
    """

    door: DoorSection = DoorSection()
    contact: ContactSection = ContactSection()
    start: StartSection = StartSection()
    goal: GoalSection = GoalSection()
    mission: MissionSection = MissionSection()
    vehicle: VehicleSection = VehicleSection()
    limits: LimitsSection = LimitsSection()
    control: ControlSection = ControlSection()
    planner: PlannerSection = PlannerSection()
    estimation: EstimationSection = EstimationSection()
    safety: SafetySection = SafetySection()
    simulation: SimulationSection = SimulationSection()
    reality: RealitySection = RealitySection()
    first: tuple[FirstSection, ...] = ()
    """Steps before the task itself, such as a lever that opens the latch."""
    campaign: CampaignSection = CampaignSection()

    _source: Path | None = PrivateAttr(default=None)

    @model_validator(mode="before")
    @classmethod
    def _with_preset(cls, values: Any) -> Any:
        return under(plain(values))

    @classmethod
    def load(cls, source: str | os.PathLike[str] = "paper", overrides: Mapping[str, Any] | None = None) -> Scenario:
        """Read a scenario and check it.

        Args:
            source: Name of a shipped scenario (`paper`, `push`) or path of a TOML file, with its suffix.
            overrides: Values by dotted key, for example `{"contact.distance_from_hinge": 0.65}`; they win over the file. Paths
                in them are relative to the working directory, those in the file to the file.

        Returns:
            The checked scenario.

        Raises:
            ScenarioError: if the file is missing or malformed, or a key is unknown, of wrong type or out of range.
        """
        path = _find_scenario(source)
        return cls._of(read_tables(path), overrides or {}, path)

    @classmethod
    def of(cls, source: Scenario | str | os.PathLike[str]) -> Scenario:
        """A scenario as it is, or read by its name or path.

        Args:
            source: The scenario, or what `load` takes.

        Raises:
            ScenarioError: see `load`.
        """
        return source if isinstance(source, Scenario) else cls.load(source)

    def replace(self, overrides: Mapping[str, Any] | None = None, /, **more: Any) -> Scenario:
        """This scenario with other values, checked.

        Args:
            overrides: Values by dotted key, as `load` takes them: `scenario.replace({"contact.height": 0.9})`.
            more: Values by key, where tables are dictionaries: `scenario.replace(contact={"height": 0.9})`; keys that are not
                named stay. Two underscores stand for a dot: `scenario.replace(contact__height=0.9)`.

        Returns:
            Another scenario.

        Raises:
            ScenarioError: if a key is unknown, or a value of wrong type or out of range.
        """
        keywords = {key.replace("__", "."): value for key, value in more.items()}
        changes = _mapping({**_mapping(overrides), **keywords})
        return self._of(self.tables(exclude_unset=self._takes_preset(changes)), changes, self._source)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the scenario with all its values to a TOML file that loads as the same task; an older file is replaced.

        Paths of files are written as absolute ones. Keys whose default follows from the URDFs and that are not set are left
        out.

        Args:
            path: The file; its directory is made.

        Returns:
            The file's absolute path: `Scenario.load(scenario.save(path)) == scenario`.

        Raises:
            ScenarioError: if the file cannot be written, or a URDF does not exist.
        """
        text, file = self.toml(), Path(path).absolute()
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        except OSError as error:
            raise ScenarioError(f"cannot be written: {error.strerror}", file=file) from error
        return file

    def toml(self) -> str:
        """The text that `save` writes.

        Raises:
            ScenarioError: if a URDF does not exist.
        """
        return toml_text(self.portable(exclude_none=True))

    def portable(self, **options: Any) -> dict[str, Any]:
        """`tables` that mean the same in any directory: URDFs are shipped names or absolute paths.

        Args:
            **options: As those of `tables`.

        Raises:
            ScenarioError: if a URDF does not exist.
        """
        tables = self.tables(**options)
        for section, path in (("vehicle", self.vehicle_urdf), ("door", self.door_urdf)):
            if path != URDF.known().get(tables[section]["urdf"].removeprefix(SHIPPED)):
                tables[section]["urdf"] = str(path)
        return tables

    def tables(self, **options: Any) -> dict[str, Any]:
        """All values as nested tables, but for defaults that grow with the vehicle (`scenario.sized`).

        Args:
            **options: As those of `model_dump`.
        """
        tables = self.model_dump(**options)
        for key in SIZED:
            *path, last = key.split(".")
            section: Any = self
            table: Any = tables
            for name in path:
                section, table = getattr(section, name), table.get(name, {})
            if last not in section.model_fields_set:
                table.pop(last, None)
        return tables

    @property
    def source(self) -> Path | None:
        """TOML file that this scenario was read from."""
        return self._source

    @property
    def name(self) -> str:
        """Name of the scenario's file without suffix."""
        return "default" if self._source is None else self._source.stem

    @property
    def vehicle_urdf(self) -> Path:
        """Path of the vehicle's URDF."""
        return self._urdf("vehicle.urdf", self.vehicle.urdf)

    @property
    def door_urdf(self) -> Path:
        """Path of the door's URDF."""
        return self._urdf("door.urdf", self.door.urdf)

    def __eq__(self, other: object) -> bool:
        return self._values() == other._values() if isinstance(other, Scenario) else NotImplemented

    def __hash__(self) -> int:
        return hashed(self._values())

    def __repr__(self) -> str:
        return f"Scenario({self.name!r}, {self.vehicle.urdf} at {self.door.urdf}, {self.contact.kind})"

    __str__ = __repr__

    @classmethod
    def _of(cls, tables: dict[str, Any], overrides: Mapping[str, Any], path: Path | None) -> Scenario:
        """Tables of a file with other values."""
        for key, value in _flat(cls, _mapping(overrides), ""):
            value = absolute(value, Path.cwd()) if key in _URDFS and isinstance(value, str) else value
            if wrong := put(tables, key, value):
                allowed = "a dotted key of the scenario"
                raise ScenarioError("not a table", file=path, field=key, given=wrong, allowed=allowed)
        check_tables(tables, ScenarioError, path)
        try:
            scenario = cls.model_validate(tables)
        except ValidationError as error:
            raise explain(cls, error, path) from None
        scenario._source = path
        drawn = {key: _absolute_choices(scenario.campaign.vary[key], scenario._folder)
                 for key in _URDFS if key in scenario.campaign.vary}  # fmt: skip
        if not drawn:
            return scenario
        campaign = scenario.campaign.model_copy(update={"vary": scenario.campaign.vary | drawn})
        return scenario.model_copy(update={"campaign": campaign})

    def _takes_preset(self, changes: Mapping[str, Any]) -> bool:
        """Whether other values bring a preset, which sets the keys that are not set here."""
        wanted = dict(_flat(type(self), changes, "")).get("reality.preset", self.reality.preset)
        if wanted != self.reality.preset and self.reality.preset is not None:
            raise ScenarioError(
                "the preset of a scenario cannot be replaced", field="reality.preset", given=wanted,
                allowed=f"{self.reality.preset!r}, or another one in Scenario.load",
            )  # fmt: skip
        return bool(wanted != self.reality.preset)

    @property
    def _folder(self) -> Path:
        """That relative paths start from."""
        return Path.cwd() if self._source is None else self._source.parent

    def _urdf(self, field: str, text: str) -> Path:
        folders = dict.fromkeys((self._folder, Path.cwd()))
        return locate(URDF, text, list(folders), self._source, field)

    def _values(self) -> dict[str, Any]:
        """All values, with files named alike wherever the scenario was read from."""
        tables = self.model_dump()
        for section in ("vehicle", "door"):
            tables[section]["urdf"] = absolute(tables[section]["urdf"], self._folder).removeprefix(SHIPPED)
        return tables


def _find_scenario(source: str | os.PathLike[str]) -> Path:
    text = plain(source)
    if not isinstance(text, str):
        raise ScenarioError("not a scenario", given=source, allowed="a name, or the path of a TOML file")
    return locate(SCENARIO, text, [Path.cwd()]).resolve()


def _mapping(overrides: Mapping[str, Any] | None) -> Mapping[str, Any]:
    given: Any = overrides or {}
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise ScenarioError("not overrides", field="overrides", given=given, allowed="values by dotted key")
    check_tables(given, ScenarioError)
    return given


def _flat(section: Any, values: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Plain values by dotted key: a dictionary given for a section changes the keys that it names."""
    for key, value in values.items():
        below = section
        for part in key.split("."):
            field = getattr(below, "model_fields", {}).get(part)
            below = None if field is None else field.annotation
        if isinstance(value, Mapping) and hasattr(below, "model_fields"):
            yield from _flat(below, _mapping(value), f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", plain(value)


def _absolute_choices(distribution: Distribution, folder: Path) -> Distribution:
    """A distribution of files, from which every one is found in any directory."""
    if distribution.choice is None:
        return distribution
    choice = tuple(absolute(item, folder) if isinstance(item, str) else item for item in distribution.choice)
    return distribution.model_copy(update={"choice": choice})
