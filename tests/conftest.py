"""Fixtures that all tests share."""

from __future__ import annotations

import numpy as np
import pytest
from at_the_door import AT_THE_DOOR
from hypothesis import settings

from doorman.model import Model
from doorman.scenario import Scenario

settings.register_profile("doorman", derandomize=True, deadline=None, database=None)
settings.load_profile("doorman")

LONG = ("test_sphinx", "test_docs", "test_startup", "test_cli_open", "test_lagrangian_planning", "test_moved_leaf",
        "test_uncompiled", "test_slams", "test_phases", "test_browser", "test_feasibility", "test_state_figure",
        "test_flights")  # fmt: skip


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files that take long come first, longest first: two processes then end together."""
    places = {name: place for place, name in enumerate(LONG)}
    items.sort(key=lambda item: places.get(item.path.stem, len(LONG)))


@pytest.fixture(scope="session")
def scenario() -> Scenario:
    """The paper's task, from the touch on."""
    return Scenario.load("paper", AT_THE_DOOR)


@pytest.fixture(scope="session")
def model(scenario: Scenario) -> Model:
    """Model of the paper's task."""
    return Model(scenario)


@pytest.fixture
def rng() -> np.random.Generator:
    """Random numbers, the same in every run."""
    return np.random.default_rng(20200531)
