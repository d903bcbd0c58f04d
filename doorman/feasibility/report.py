"""Findings of a check, and the report that gathers them."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from doorman.collision.audit import AuditReport
from doorman.collision.scene import Clearance
from doorman.exceptions import InfeasibleError
from doorman.one_line import OneLine

SPARE = 0.01
"""Room beyond what is needed below which gusts and errors of tracking make the mission give up, of the shipped vehicle [m]."""


class FeasibilityWarning(UserWarning):
    """A warning of the check: the task can work, but something is near its limit or not as the models assume."""


class Severity(StrEnum):
    """How much a finding matters."""

    OK = "ok"
    WARNING = "warning"
    """The task can work, but something is near its limit or not as the models assume."""
    ERROR = "error"
    """The task cannot work as it is."""


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at."""

    name: str
    severity: Severity
    message: str
    """One sentence with the numbers in it."""
    value: float | None
    limit: float | None
    unit: str
    """Unit of value and limit."""
    advice: str = ""
    """What to change, with the scenario's keys; empty where nothing needs to be."""

    @property
    def ok(self) -> bool:
        """Whether there is nothing to complain about."""
        return self.severity is Severity.OK

    @property
    def words(self) -> str:
        """Message and advice, each on its line."""
        return f"{self.message}\n→ {self.advice}" if self.advice else self.message

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain types that JSON can hold; a number that is not finite becomes None."""
        values = {**asdict(self), "severity": self.severity.value}
        for key in ("value", "limit"):
            number = values[key]
            values[key] = number if number is not None and math.isfinite(number) else None
        return values


@dataclass(frozen=True, repr=False)
class Report(OneLine):
    """All findings about one scenario."""

    scenario: str
    findings: tuple[Finding, ...]
    audit: AuditReport | None = None
    """Audit of the analytic constraints by FCL; None without `with_audit`."""

    @property
    def possible(self) -> bool:
        """Whether no finding is an error."""
        return not self.errors

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings that make the task impossible."""
        return tuple(finding for finding in self.findings if finding.severity is Severity.ERROR)

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """The findings that do not make the task impossible, but are worth a look."""
        return tuple(finding for finding in self.findings if finding.severity is Severity.WARNING)

    @property
    def complaints(self) -> tuple[Finding, ...]:
        """All findings that are not OK, errors first."""
        return (*self.errors, *self.warnings)

    @property
    def sentence(self) -> str:
        """Whether the scenario is possible, and what makes it impossible."""
        if self.possible:
            return f"The scenario '{self.scenario}' is possible."
        return f"The scenario '{self.scenario}' is not possible: {', '.join(finding.name for finding in self.errors)}."

    def refuse(self) -> None:
        """Refuse a task that cannot work.

        Raises:
            InfeasibleError: if a finding is an error.
        """
        if self.errors:
            words = "; ".join(f"{finding.name}: {finding.message}" for finding in self.errors)
            names = tuple(finding.name for finding in self.errors)
            raise InfeasibleError(f"the scenario '{self.scenario}' is not possible: {words}", names)

    def __getitem__(self, name: str) -> Finding:
        for finding in self.findings:
            if finding.name == name:
                return finding
        raise KeyError(f"no finding '{name}'; there are: {', '.join(finding.name for finding in self.findings)}")

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain types that JSON can hold."""
        findings = [finding.as_dict() for finding in self.findings]
        audit = None if self.audit is None else self.audit.as_dict()
        return {"scenario": self.scenario, "possible": self.possible, "findings": findings, "audit": audit}


def found(
    name: str, ok: bool, message: str, value: float | None, limit: float | None, unit: str, advice: str = "",
    worse: Severity = Severity.ERROR,
) -> Finding:  # fmt: skip
    """A finding: OK and without advice, or as bad as `worse`."""
    return Finding(name, Severity.OK if ok else worse, message, value, limit, unit, "" if ok else advice)


def warning_if(enough: bool) -> Severity:
    """How bad it is to be near a limit: a warning on its good side, else an error."""
    return Severity.WARNING if enough else Severity.ERROR


def near(worst: Clearance) -> str:
    """The closest pair of shapes, in words."""
    how = "come as near as" if worst.distance > 0.0 else "overlap by"
    return f"{worst.first} and {worst.second} {how} {1e3 * abs(worst.distance):.1f} mm"
