"""A rule of one parameter: which values it accepts, which one to write, why, and for which set-ups it holds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from enum import Enum

from doorman.hardware.pixhawk.config import PixhawkConfig


class Severity(Enum):
    """What a finding means."""

    ERROR = "error"
    """The flight cannot work, or a fault would not end safely; whoever flies decides whether it is flown so."""
    WARNING = "warning"  # it can work, worse


class When(Enum):
    ALWAYS = "always"
    MOCAP = "mocap"
    ATTITUDE = "attitude setpoints"
    OWN_COMPENSATION = "thrust curve with battery voltage"


@dataclass(frozen=True)
class Rule:
    names: tuple[str, ...]  # of the parameter, newest firmware first; the first that the autopilot has counts
    wanted: str  # in words
    accepts: Callable[[float], bool]
    value: Callable[[float], float] | None  # value to write for a given one; None where a person must decide
    severity: Severity
    why: str
    when: When = When.ALWAYS
    optional: bool = False  # whether firmware without the parameter is fine
    only_with: tuple[str, int] | None = None
    """Another parameter and the value that it must have for this one to count; it has a rule of its own."""

    @property
    def condition(self) -> str:
        """Set-ups for which the rule counts, in words."""
        return self.when.value if self.only_with is None else "{} {}".format(*self.only_with)

    def counts(self, values: Mapping[str, float]) -> bool:
        """Whether the rule counts with these values of the other parameters."""
        return self.only_with is None or values.get(self.only_with[0]) == self.only_with[1]

    def applies(self, config: PixhawkConfig) -> bool:
        """Whether the rule holds for a set-up."""
        curve = config.thrust_curve
        return {
            When.ALWAYS: True,
            When.MOCAP: config.mocap,
            When.ATTITUDE: config.setpoints == "attitude",
            When.OWN_COMPENSATION: curve is not None and curve.hover_voltage is not None,
        }[self.when]


def equal(
    names: str, value: float, severity: Severity, why: str, *, optional: bool = False, near: float = 1e-4
) -> Rule:
    """Rule of a parameter that has one right value."""
    return Rule(
        tuple(names.split()), f"{value:g}", lambda given: abs(given - value) <= near, lambda _: value, severity, why,
        optional=optional,
    )  # fmt: skip


def within(
    names: str, low: float, high: float, best: float, severity: Severity, why: str, *, optional: bool = False
) -> Rule:
    """Rule of a parameter with a range."""
    return Rule(
        tuple(names.split()), f"{low:g} to {high:g}", lambda given: low <= given <= high, lambda _: best, severity, why,
        optional=optional,
    )  # fmt: skip


def one_of(names: str, values: tuple[int, ...], severity: Severity, why: str, *, optional: bool = False) -> Rule:
    """Rule of a parameter with a few right values."""
    wanted, best = " or ".join(map(str, values)), float(values[0])
    return Rule(
        tuple(names.split()),
        wanted,
        lambda given: round(given) in values,
        lambda _: best,
        severity,
        why,
        optional=optional,
    )


def bit(names: str, bit: int, severity: Severity, why: str) -> Rule:
    """Rule of a parameter with a bit that must be set; its other bits stay."""
    mask = 1 << bit
    return Rule(
        tuple(names.split()), f"bit {bit} ({mask}) set", lambda given: bool(round(given) & mask),
        lambda given: float(round(given) | mask), severity, why,
    )  # fmt: skip


def where(other: str, value: int, *rules: Rule) -> tuple[Rule, ...]:
    """Rules that count only where another parameter has a value."""
    return tuple(replace(rule, only_with=(other, value)) for rule in rules)


def when(set_up: When, *rules: Rule) -> tuple[Rule, ...]:
    """Rules that count only for a set-up."""
    return tuple(replace(rule, when=set_up) for rule in rules)
