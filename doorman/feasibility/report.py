"""Findings of a check, and the report that gathers them."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from doorman.collision.audit import AuditReport
from doorman.one_line import OneLine


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
    """Of value and limit."""
    advice: str = ""
    """What to change, with the scenario's keys; empty where nothing needs to be."""

    @property
    def ok(self) -> bool:
        """Whether there is nothing to complain about."""
        return self.severity is Severity.OK


@dataclass(frozen=True, repr=False)
class Report(OneLine):
    """All findings about one scenario."""

    scenario: str
    findings: tuple[Finding, ...]
    audit: AuditReport | None = None
    """Of the analytic constraints by FCL."""

    @property
    def possible(self) -> bool:
        """Whether no finding is an error."""
        return all(finding.severity is not Severity.ERROR for finding in self.findings)

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings that make the task impossible."""
        return tuple(finding for finding in self.findings if finding.severity is Severity.ERROR)

    def __getitem__(self, name: str) -> Finding:
        """The finding of a name."""
        for finding in self.findings:
            if finding.name == name:
                return finding
        raise KeyError(f"no finding '{name}'; there are: {', '.join(finding.name for finding in self.findings)}")

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain types that JSON can hold; an infinite limit becomes None."""
        findings = [{**asdict(finding), "severity": finding.severity.value} for finding in self.findings]
        for finding in findings:
            for key in ("value", "limit"):
                number = finding[key]
                finding[key] = number if number is not None and math.isfinite(number) else None
        audit = None if self.audit is None else self.audit.as_dict()
        return {"scenario": self.scenario, "possible": self.possible, "findings": findings, "audit": audit}


def graded(ok: bool, worse: Severity = Severity.ERROR) -> Severity:
    """OK where something holds, else `worse`."""
    return Severity.OK if ok else worse
