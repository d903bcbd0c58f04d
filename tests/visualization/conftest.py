"""A flight that the figures and pages of these tests show."""

from __future__ import annotations

import pytest
from simple_flight import fly

from doorman.model import Model
from doorman.recording import Recording


@pytest.fixture(scope="session")
def flight(model: Model) -> Recording:
    """Five seconds of the paper's task."""
    return fly(model, 5.0)
