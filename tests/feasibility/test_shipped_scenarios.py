"""What ships is possible."""

from __future__ import annotations

import pytest

from doorman.feasibility import check
from doorman.resources import scenario_directory, shipped
from doorman.scenario import Scenario


@pytest.mark.parametrize("name", sorted(shipped(scenario_directory(), ".toml")))
def test_the_check_finds_it_possible(name: str) -> None:
    report = check(Scenario.load(name))
    assert report.possible, [finding.words for finding in report.complaints]
