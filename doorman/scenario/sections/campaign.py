"""Campaigns: how many flights, and what is drawn for each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, field_validator, model_validator

from doorman.scenario.values import NonNegative, Number, Positive, Section


class Distribution(Section):
    """How one value of a campaign is drawn.

    Evenly between `min` and `max`, from a `choice`, with `mean` and `std`, or as another key is (`same_as`).
    """

    min: Number | None = None
    max: Number | None = None
    choice: Annotated[tuple[Any, ...], Field(min_length=1)] | None = None
    """Each entry as likely as the others."""
    mean: Number | None = None
    std: NonNegative | None = None
    """Standard deviation of a normal distribution."""
    same_as: str | None = None
    """Another key that is drawn, whose value this one gets."""

    @model_validator(mode="after")
    def _one_form(self) -> Distribution:
        if {name for name, value in self if value is not None} not in (
            {"min", "max"}, {"choice"}, {"mean", "std"}, {"same_as"},
        ):  # fmt: skip
            raise ValueError("min and max, or choice, or mean and std, or same_as")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError("min up to max")
        return self


class CampaignSection(Section):
    """Many flights of the same task, each with values drawn by chance."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Seed of all draws."""
    runs: Annotated[int, Field(strict=True, ge=1, le=1_000_000)] = 200
    """Number of flights."""
    duration: Positive | None = None
    """Longest flight [s]. Default: until it ends by itself."""
    time_out: Positive = 1800.0
    """Wall-clock time after which a flight is given up [s]."""
    vary: dict[str, Distribution] = {}
    """What is drawn for every run: a table of the scenario's keys, each with `{ min = …, max = … }`, `{ choice = [ … ]
    }`, `{ mean = …, std = … }` or `{ same_as = … }`."""

    @field_validator("vary", mode="before")
    @classmethod
    def _dotted(cls, tables: Any) -> Any:
        return distributions(tables) if isinstance(tables, dict) else tables

    @field_validator("vary")
    @classmethod
    def _sources_are_drawn(cls, vary: dict[str, Distribution]) -> dict[str, Distribution]:
        drawn = [key for key, distribution in vary.items() if distribution.same_as is None]
        for key, distribution in vary.items():
            if distribution.same_as is not None and distribution.same_as not in drawn:
                raise ValueError(f"{key}: same_as one of {', '.join(drawn) or 'none, as no key is drawn by itself'}")
        return vary


def distributions(tables: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Distributions by dotted key, of tables however deep: `a.b = {…}` is as good as `"a.b" = {…}`."""
    flat: dict[str, Any] = {}
    for key, value in tables.items():
        nested = isinstance(value, Mapping) and value and all(isinstance(item, Mapping) for item in value.values())
        flat |= distributions(value, f"{prefix}{key}.") if nested else {prefix + key: value}
    return flat
