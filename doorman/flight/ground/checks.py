"""Rows of the pre-flight checklist, and whether the vehicle may be flown by them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Verdict(Enum):
    """Result of one check."""

    GOOD = "ok"
    WARNING = "warning"
    BAD = "no"


@dataclass(frozen=True)
class Check:
    """One row of the checklist."""

    name: str
    verdict: Verdict
    found: str
    advice: str = ""


def ready(checks: list[Check]) -> bool:
    """Whether the vehicle may be flown.

    Args:
        checks: Of `preflight`.
    """
    return all(one.verdict is not Verdict.BAD for one in checks)


def row(name: str, good: bool, found: str, advice: str, otherwise: Verdict = Verdict.BAD) -> Check:
    """A row that gives its advice only where it is needed."""
    return Check(name, Verdict.GOOD if good else otherwise, found, "" if good else advice)
