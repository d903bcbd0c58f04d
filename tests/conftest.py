"""Fixtures that all tests share."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator

import numpy as np
import pytest
from at_the_door import AT_THE_DOOR
from hypothesis import settings

from doorman.model import Model
from doorman.scenario import Scenario

settings.register_profile("doorman", derandomize=True, deadline=None, database=None)
settings.load_profile("doorman")


def pytest_collection_finish() -> None:
    """Keep the garbage collector from looking at thousands of tests and modules again and again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session", autouse=True)
def _no_solver_outlives_the_tests() -> Iterator[None]:
    """Solvers that tests share are let go at the end: their library complains about any it outlives."""
    yield
    if tasks := sys.modules.get("door_tasks"):
        for function in (tasks.planner_of, tasks.reference_of, tasks.model_of):
            function.cache_clear()


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
