"""Solvers that the tests of this directory share are let go at the end: their library complains about any it outlives."""

from __future__ import annotations

from collections.abc import Iterator

import door_tasks
import pytest


@pytest.fixture(scope="session", autouse=True)
def _no_solver_outlives_the_tests() -> Iterator[None]:
    yield
    for function in (door_tasks.planner_of, door_tasks.reference_of, door_tasks.model_of):
        function.cache_clear()
