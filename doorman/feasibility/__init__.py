"""Feasibility: says before any flight whether a scenario can work, and what to change where it cannot."""

from doorman.feasibility.check import beforehand, check
from doorman.feasibility.report import Finding, Report, Severity

__all__ = ["Finding", "Report", "Severity", "beforehand", "check"]
