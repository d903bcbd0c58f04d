"""Fixtures of the adapter's tests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from autopilot_sandbox import Sandbox
from pixhawk_parts import CONFIG
from pixhawk_rig import Rig

from doorman.hardware.pixhawk import Authority
from doorman.hardware.pixhawk.events import LinkLog
from doorman.hardware.pixhawk.link.stream import SetpointStream
from doorman.rig.emulators.autopilot.dialects import ARDUPILOT, PX4


@pytest.fixture
def rigs() -> Iterator[Callable[..., Rig]]:
    """Makes rigs, which end with the test: `rigs("px4", config={...}, vision=True)`."""
    made: list[Rig] = []

    def make(flavour: str = "px4", config: dict[str, Any] | None = None, **emulator: Any) -> Rig:
        made.append(Rig(flavour, emulator, config or {}))
        return made[-1]

    yield make
    for rig in made:
        rig.stop()


@pytest.fixture(scope="module")
def hovering() -> Iterator[Callable[[str], Rig]]:
    """A vehicle of a flavour in the air under our command, shared by the tests of a module that leave it there."""
    made: dict[str, Rig] = {}

    def get(flavour: str) -> Rig:
        if flavour not in made:
            made[flavour] = Rig(flavour, {}, {})
            made[flavour].fly()
        rig = made[flavour]
        rig.pilot.resume()
        assert rig.pilot.status().authority is Authority.ENGAGED or rig.pilot.engage().done
        rig.forget()
        return rig

    yield get
    for rig in made.values():
        rig.stop()


@pytest.fixture(params=["px4", "ardupilot"])
def flavour(request: pytest.FixtureRequest) -> str:
    """Both autopilots in turn."""
    return str(request.param)


@pytest.fixture
def events() -> LinkLog:
    """A log of its own for every test."""
    return LinkLog()


@pytest.fixture
def stream(events: LinkLog) -> SetpointStream:
    """A stream that notes its events in that log."""
    return SetpointStream(CONFIG, events)


@pytest.fixture
def vehicle_px4() -> Sandbox:
    """PX4's rules."""
    return Sandbox(PX4)


@pytest.fixture
def vehicle_ardupilot() -> Sandbox:
    """ArduPilot's rules."""
    return Sandbox(ARDUPILOT)
