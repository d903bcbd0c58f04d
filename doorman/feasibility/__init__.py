"""Feasibility: says before any flight whether a scenario can work, and what to change where it cannot."""

from doorman.feasibility.check import check
from doorman.feasibility.report import FeasibilityWarning, Finding, Report, Severity

__all__ = ["FeasibilityWarning", "Finding", "Report", "Severity", "check"]
