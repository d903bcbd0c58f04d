"""Campaign: one scenario, what varies in it, and the flights that follow from them."""

from __future__ import annotations

import json
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from doorman.campaign.draws import Draw, draw
from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.resources import shipped, urdf_directory
from doorman.scenario import Scenario
from doorman.scenario.files import absolute


@dataclass(frozen=True)
class Flight:
    """One run, as it is sent to where it is flown."""

    draw: Draw
    scenario: Scenario
    duration: float | None
    """Longest flight [s]; None: it ends by itself."""
    time_out: float
    """Wall-clock time [s]."""
    command: str
    """What flies it again, by hand."""

    def order(self) -> dict[str, Any]:
        """Everything that the flight depends on, for JSON."""
        return {
            "run": self.draw.run,
            "seed": self.draw.seed,
            "duration": self.duration,
            "scenario": portable(self.scenario),
        }


@dataclass(frozen=True)
class Campaign:
    """A scenario with its distributions.

    Args:
        source: Name or path of the scenario.
        overrides: Values by dotted key, for all runs.
    """

    source: str
    overrides: Mapping[str, Any] = field(default_factory=dict)

    @property
    def scenario(self) -> Scenario:
        """The scenario that the runs vary."""
        return Scenario.load(self.source, self.overrides)

    def flights(self, runs: int | None = None) -> list[Flight]:
        """All runs, each checked as far as that is possible without flying it.

        Args:
            runs: How many; by default the scenario's.

        Returns:
            The flights, in the order of their numbers.

        Raises:
            ScenarioError: if a drawn key is unknown, or a drawn value is out of range.
        """
        campaign = self.scenario.campaign
        if not campaign.vary:
            raise ScenarioError(
                "nothing varies", file=self.scenario.source, field="campaign.vary", allowed="a table of distributions"
            )
        count = campaign.runs if runs is None else runs
        flights = [self._flight(draw(campaign, run)) for run in range(count)]
        Model(flights[0].scenario)
        return flights

    def _flight(self, drawn: Draw) -> Flight:
        overrides = {**self.overrides, **drawn.values}
        scenario = Scenario.load(self.source, overrides)
        campaign = scenario.campaign
        return Flight(
            drawn,
            scenario,
            campaign.duration,
            campaign.time_out,
            self._command(drawn.seed, campaign.duration, overrides),
        )

    def _command(self, seed: int, duration: float | None, overrides: Mapping[str, Any]) -> str:
        source = absolute(self.source, Path.cwd())
        words = ["doorman", "open", source, "--seed", str(seed)]
        if duration is not None:
            words += ["--duration", repr(duration)]
        for key, value in overrides.items():
            words += ["--set", f"{key}={json.dumps(value, ensure_ascii=False)}"]
        return shlex.join(words)


def portable(scenario: Scenario) -> dict[str, Any]:
    """A scenario as JSON that is the same task in any directory; URDFs that do not ship are absolute paths."""
    tables = scenario.model_dump(mode="json")
    known = shipped(urdf_directory(), ".urdf").values()
    for section, path in (("vehicle", scenario.vehicle_urdf), ("door", scenario.door_urdf)):
        tables[section]["urdf"] = path.stem if path in known else str(path)
    return tables
