"""Holds every observation against the rules and remembers since when each of them has been broken."""

from __future__ import annotations

from dataclasses import dataclass

from doorman.hardware.safety.observation import Observation
from doorman.hardware.safety.rules import RULES, Action, Fault
from doorman.scenario import SafetySection


@dataclass(frozen=True)
class Finding:
    """A fault that lasted for as long as it may."""

    fault: Fault
    action: Action
    time: float
    """When it was found, by `time.monotonic` [s]."""
    lasted: float
    """For how long it held by then [s]."""

    def __str__(self) -> str:
        return f"{self.fault.value}: {self.action.name.lower()}"


class Assessor:
    """Rules with their memory; every fault is found once until it has passed.

    Args:
        limits: Bounds.
    """

    def __init__(self, limits: SafetySection) -> None:
        self.limits = limits
        self._since: dict[Fault, float] = {}
        self._found: set[Fault] = set()

    def assess(self, seen: Observation) -> list[Finding]:
        """Faults that are found in this observation.

        Args:
            seen: What is seen; not before the last one.

        Returns:
            New findings, the gravest action first; nothing while the vehicle is not armed.
        """
        if not seen.armed:
            self._since.clear()
            self._found.clear()
            return []
        findings = []
        for rule in RULES:
            if not rule.holds(seen, self.limits):
                self._since.pop(rule.fault, None)
                self._found.discard(rule.fault)
                continue
            lasted = seen.now - self._since.setdefault(rule.fault, seen.now)
            if lasted >= rule.patience - 1e-9 and rule.fault not in self._found:
                self._found.add(rule.fault)
                findings.append(Finding(rule.fault, rule.action, seen.now, lasted))
        return sorted(findings, key=lambda finding: -finding.action)
