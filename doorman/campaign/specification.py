"""Campaign: one scenario, what varies in it, and the flights that follow from them."""

from __future__ import annotations

import json
import shlex
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, overload

import numpy as np

from doorman.exceptions import ScenarioError
from doorman.model import Model
from doorman.scenario import CampaignSection, Distribution, Scenario
from doorman.scenario.files import absolute

_DIGITS = 6
"""Drawn numbers are rounded to so many significant digits: they are flown as they are written."""
_SEEDS = 2**31
"""Seeds of flights are below."""


@dataclass(frozen=True)
class Draw:
    run: int
    seed: int  # of the flight's noise, gaps and gusts
    values: dict[str, Any]  # by dotted key of the scenario


def draw(campaign: CampaignSection, run: int) -> Draw:
    """Draw one run."""
    # Every value has random numbers of its own, made from the campaign's seed, the run and the key (or the one that it is the
    # same as): neither the number of runs, nor their order, nor what else is varied changes it.
    seed = int(np.random.default_rng([campaign.seed, run]).integers(_SEEDS))
    values = {}
    for key, distribution in campaign.vary.items():
        source = key if distribution.same_as is None else distribution.same_as
        generator = np.random.default_rng([campaign.seed, run, zlib.crc32(source.encode())])
        values[key] = _value(campaign.vary[source], generator)
    return Draw(run, seed, values)


def _value(distribution: Distribution, generator: np.random.Generator) -> Any:
    if distribution.choice is not None:
        return distribution.choice[int(generator.integers(len(distribution.choice)))]
    if distribution.mean is not None and distribution.std is not None:
        return _rounded(distribution.mean + distribution.std * generator.standard_normal())
    if distribution.min is None or distribution.max is None:
        raise AssertionError("what is drawn by itself has one of three forms")
    return min(max(_rounded(generator.uniform(distribution.min, distribution.max)), distribution.min), distribution.max)


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}")


@dataclass(frozen=True)
class Flight:
    """One run, as it is sent to where it is flown."""

    draw: Draw
    scenario: Scenario
    duration: float | None  # longest flight [s]; None: it ends by itself
    time_out: float  # wall-clock time [s]
    command: str  # what flies it again, by hand


@dataclass(frozen=True)
class Campaign:
    """A scenario with its distributions.

    Args:
        source: Name or path of the scenario.
        overrides: Values by dotted key, for all runs.
        vehicle: Vehicle file that some of them are of, for the command that flies a run again; `None` among them is a key that
            the file leaves to its default.
    """

    source: str
    overrides: Mapping[str, Any] = field(default_factory=dict)
    vehicle: str | None = None

    @property
    def scenario(self) -> Scenario:
        """The scenario that the runs vary."""
        return Scenario.load(self.source, self.overrides)

    def flights(self, runs: int | None = None) -> Flights:
        """All runs, each drawn on access; the ends of all ranges, and the first run, are checked at once.

        Args:
            runs: How many; by default the scenario's.

        Returns:
            The flights, in the order of their numbers.

        Raises:
            ScenarioError: if a drawn key is unknown, or an end of its range is not allowed.
        """
        campaign = self.scenario.campaign
        if not campaign.vary:
            raise ScenarioError(
                "no key varies", file=self.scenario.source, field="campaign.vary", allowed="a table of distributions"
            )
        for key, distribution in campaign.vary.items():
            for value in _ends(distribution):
                Scenario.load(self.source, {**self.overrides, key: value})
        flights = Flights(self, campaign.runs if runs is None else runs)
        Model(flights[0].scenario)
        return flights

    def flight(self, run: int) -> Flight:
        """Flight of one run.

        Args:
            run: Its number.

        Raises:
            ScenarioError: if a drawn value is out of range.
        """
        drawn = draw(self._section, run)
        return self._flight(drawn, Scenario.load(self.source, {**self.overrides, **drawn.values}))

    def undrawn(self, run: int) -> Flight:
        """A run whose draws cannot be flown, with the scenario unchanged, for its row in the results.

        Args:
            run: Number of the run.
        """
        return self._flight(draw(self._section, run), self.scenario)

    @cached_property
    def _section(self) -> CampaignSection:
        return self.scenario.campaign

    def _flight(self, drawn: Draw, scenario: Scenario) -> Flight:
        campaign = scenario.campaign
        return Flight(drawn, scenario, campaign.duration, campaign.time_out, self._command(drawn, campaign.duration))

    def _command(self, drawn: Draw, duration: float | None) -> str:
        source = absolute(self.source, Path.cwd())
        words = ["doorman", "open", source, "--seed", str(drawn.seed)]
        if duration is not None:
            words += ["--duration", repr(duration)]
        if self.vehicle is not None:
            words += ["--vehicle", absolute(self.vehicle, Path.cwd())]
        for key, value in {**self.overrides, **drawn.values}.items():
            if value is not None:
                words += ["--set", f"{key}={json.dumps(value, ensure_ascii=False)}"]
        return shlex.join(words)


class Flights(Sequence[Flight]):
    """The runs of a campaign, each drawn on access: a million take no memory."""

    def __init__(self, campaign: Campaign, count: int) -> None:
        self._campaign, self._runs = campaign, range(count)

    def __len__(self) -> int:
        return len(self._runs)

    @overload
    def __getitem__(self, index: int) -> Flight: ...
    @overload
    def __getitem__(self, index: slice) -> list[Flight]: ...
    def __getitem__(self, index: int | slice) -> Flight | list[Flight]:
        if isinstance(index, slice):
            return [self._campaign.flight(run) for run in self._runs[index]]
        return self._campaign.flight(self._runs[index])


def _ends(distribution: Distribution) -> tuple[Any, ...]:
    """Values between which a distribution draws, or all it chooses from; the middle of one without ends."""
    if distribution.choice is not None:
        return tuple(distribution.choice)
    given = (distribution.min, distribution.max, distribution.mean)
    return tuple(value for value in given if value is not None)
