"""The flight of a check: as long as an idle core flies in some seconds, and judged by what was flown."""

from __future__ import annotations

import pytest

from doorman.feasibility import Report, Severity
from doorman.mission import settled as settling
from doorman.model import Model


def test_a_flight_that_is_not_over_is_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(settling, "LONGEST", 0.5)
    report = settling.settled(Model("paper"), Report("paper", ()))
    finding = report["flight"]
    assert finding.severity is Severity.WARNING and report.possible
    assert finding.value is not None and finding.limit is not None and finding.value > finding.limit
