"""One rig for all flights of this folder; DOORMAN_RIG_SCENARIO=push in the environment has them push the door."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from flight_rig import FlightRig

from doorman.flight import rehearse
from doorman.hardware.scheduling import real_time


@pytest.fixture(scope="session")
def running_rig(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FlightRig]:
    rig = FlightRig(tmp_path_factory.mktemp("rig"))
    rehearse(rig.model, rig.planner)
    with real_time():  # where the system permits it, a busy computer does not disturb the flights
        try:
            rig.open()
            yield rig
        finally:
            rig.stop()


@pytest.fixture
def rig(running_rig: FlightRig) -> Iterator[FlightRig]:
    """The rig, well and on its pad, before every test."""
    running_rig.heal()
    yield running_rig
