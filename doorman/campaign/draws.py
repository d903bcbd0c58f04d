"""Draws: what every run of a campaign is flown with, from the campaign's seed and the run's number alone."""

from __future__ import annotations

import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from doorman.scenario import CampaignSection, Distribution

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
