"""Keys of older scenarios: the error says what replaces them."""

from __future__ import annotations

from pathlib import Path

import pytest

from doorman.exceptions import ScenarioError
from doorman.scenario import ControlSection, Scenario
from doorman.scenario.gone import GONE


@pytest.mark.parametrize("key", GONE)
def test_a_key_that_went_says_what_replaces_it(key: str) -> None:
    with pytest.raises(ScenarioError, match="is gone") as found:
        Scenario.load("push", {key: 1.0})
    assert key in str(found.value) and GONE[key] in str(found.value)


def test_a_table_that_went_names_its_key(tmp_path: Path) -> None:
    path = tmp_path / "old.toml"
    path.write_text("[push]\nmax_rate = 0.5\n")
    with pytest.raises(ScenarioError, match=r"'push\.max_rate' is gone: goal\.duration"):
        Scenario.load(path)


def test_a_slip_of_the_pen_still_names_the_nearest_key() -> None:
    with pytest.raises(ScenarioError, match="nearest is 'duration'"):
        Scenario.load("push", {"goal.duratoin": 8.0})
    with pytest.raises(ScenarioError, match="control.arm_look_ahead"):
        ControlSection(arm_look_ahead=0.1)  # type: ignore[call-arg]
    with pytest.raises(ScenarioError, match="nearest is 'goal'"):
        Scenario.load("push", {"goa": 8.0})
    with pytest.raises(
        ScenarioError, match="nearest"
    ):  # a number of the filter has that name, and no key of the controller
        ControlSection(rate=0.1)  # type: ignore[call-arg]


@pytest.mark.parametrize("duration", ["fast", 0.0, -1.0, True, float("inf")])
def test_a_duration_is_a_time_or_safe(duration: object) -> None:
    with pytest.raises(ScenarioError, match="safe"):
        Scenario.load("push", {"goal.duration": duration})
