"""`Scenario`: all sections of one task, read from TOML and checked."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import PrivateAttr, ValidationError

from doorman.exceptions import ScenarioError
from doorman.resources import scenario_directory, shipped, urdf_directory
from doorman.scenario.campaign import CampaignSection
from doorman.scenario.errors import explain
from doorman.scenario.flight import ControlSection, EstimationSection, MissionSection
from doorman.scenario.planning import LimitsSection, PlannerSection, PushSection
from doorman.scenario.safety import SafetySection
from doorman.scenario.simulation import SimulationSection
from doorman.scenario.task import ContactSection, DoorSection, GoalSection, StartSection, VehicleSection
from doorman.scenario.values import Section


class Scenario(Section):
    """One task: URDFs, contact, start, goal, and the options of planner, controller and simulator.

    Make one with `Scenario.load`; `Scenario()` is the paper's task.
    """

    vehicle: VehicleSection = VehicleSection()
    door: DoorSection = DoorSection()
    contact: ContactSection = ContactSection()
    start: StartSection = StartSection()
    goal: GoalSection = GoalSection()
    planner: PlannerSection = PlannerSection()
    limits: LimitsSection = LimitsSection()
    push: PushSection = PushSection()
    control: ControlSection = ControlSection()
    estimation: EstimationSection = EstimationSection()
    mission: MissionSection = MissionSection()
    safety: SafetySection = SafetySection()
    simulation: SimulationSection = SimulationSection()
    campaign: CampaignSection = CampaignSection()

    _source: Path | None = PrivateAttr(default=None)

    @classmethod
    def load(cls, source: str | Path = "paper", overrides: Mapping[str, Any] | None = None) -> Scenario:
        """Read a scenario and check it.

        Args:
            source: Name of a shipped scenario (`paper`, `push`) or path of a TOML file.
            overrides: Values by dotted key, for example `{"contact.distance_from_hinge": 0.65}`; they win over the file.

        Returns:
            The checked scenario.

        Raises:
            ScenarioError: if the file is missing or malformed, or a key is unknown, of wrong type or out of range.
        """
        path = _find_scenario(source)
        try:
            tables = tomllib.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError) as error:  # syntax, encoding, integers or nesting beyond Python's limits
            raise ScenarioError(f"not valid TOML: {error}", file=path, allowed="TOML 1.0 in UTF-8") from error
        except OSError as error:
            raise ScenarioError(f"cannot be read: {error.strerror}", file=path) from error
        for key, value in (overrides or {}).items():
            _set(tables, key, value, path)
        try:
            scenario = cls.model_validate(tables)
        except ValidationError as error:
            raise explain(cls, error, path) from None
        scenario._source = path
        return scenario

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

    def _urdf(self, field: str, name: str) -> Path:
        known = shipped(urdf_directory(), ".urdf")
        if name.removesuffix(".urdf") in known:
            return known[name.removesuffix(".urdf")]
        bases = [Path.cwd()] if self._source is None else [self._source.parent, Path.cwd()]
        for base in bases:
            if (base / name).is_file():
                return (base / name).resolve()
        raise ScenarioError(
            "no such URDF",
            file=self._source,
            field=field,
            given=name,
            allowed=f"a shipped name ({', '.join(known)}) or a path relative to the scenario file",
        )


def _find_scenario(source: str | Path) -> Path:
    known = shipped(scenario_directory(), ".toml")
    if str(source) in known:
        return known[str(source)]
    path = Path(source)
    try:
        if path.is_file():
            return path.resolve()
    except OSError as error:
        raise ScenarioError(f"cannot be read: {error.strerror}", given=str(source)[:80]) from error
    close = difflib.get_close_matches(str(source), known, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    raise ScenarioError(
        f"no such scenario{hint}", given=str(source), allowed=f"{', '.join(known)}, or the path of a TOML file"
    )


def _set(tables: dict[str, Any], key: str, value: Any, path: Path) -> None:
    *sections, last = key.split(".")
    table = tables
    for section in sections:
        table = table.setdefault(section, {})
        if not isinstance(table, dict):
            raise ScenarioError(
                "not a table", file=path, field=key, given=section, allowed="a dotted key of the scenario"
            )
    table[last] = list(value) if isinstance(value, tuple) else value
