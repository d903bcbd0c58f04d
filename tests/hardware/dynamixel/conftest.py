"""Emulated servos and buses on pseudo-terminals; everything that a test opens is closed again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest
from servo_client import Client
from servo_rig import FASTEST, LOWER, UPPER, Rig
from virtual_time import CLOCK

from doorman.hardware.dynamixel import ServoConfig
from doorman.rig.emulators.servos import ServoEmulator
from doorman.rig.emulators.servos.bus import LaggingJoints


@pytest.fixture
def make_emulator() -> Iterator[Callable[..., ServoEmulator]]:
    """Start emulated servos; `angles` is where the joints are. Answers take their time: else none would pass in virtual time."""
    with ExitStack() as stack:

        def make(servos: Any = (1, 2, 3, 4), angles: Any = None, plant: Any = None, **options: Any) -> ServoEmulator:
            plant = plant or LaggingJoints(np.zeros(len(servos)) if angles is None else angles)
            return stack.enter_context(
                ServoEmulator(servos, plant, **{"clock": CLOCK, "baud_rate": 1_000_000} | options)
            )

        yield make


@pytest.fixture
def make_rig(make_emulator: Callable[..., ServoEmulator]) -> Iterator[Callable[..., Rig]]:
    """Emulated servos with a bus that is not open yet; keywords are fields of `ServoConfig`."""
    rigs = []

    def make(emulator: ServoEmulator | None = None, **fields: Any) -> Rig:
        emulator = emulator or make_emulator()
        n = len(fields.get("ids", (1, 2, 3, 4)))
        # Loaded machines are slow: faults are told from delays of the test by wider times than in flight.
        given = {"stale_after": 0.06, "latency": 0.012, "command_timeout": 0.5} | fields
        config = ServoConfig(emulator.port, **{"lower_limits": LOWER[:n], "upper_limits": UPPER[:n],
                                               "rate_limits": FASTEST[:n]} | given)  # fmt: skip
        rigs.append(Rig(emulator, config))
        return rigs[-1]

    yield make
    for rig in rigs:
        rig.bus.stop()


@pytest.fixture
def rig(make_rig: Callable[..., Rig]) -> Rig:
    """Four servos with an open bus."""
    made = make_rig()
    made.bus.open()
    return made


@pytest.fixture
def client(connect):
    return connect()[1]


@pytest.fixture
def connect(make_emulator):
    """Client of an emulator with options."""
    clients = []

    def make(*arguments, **options):
        emulator = make_emulator(*arguments, **options)
        clients.append(Client(emulator))
        return emulator, clients[-1]

    yield make
    for client in clients:
        client.port.closePort()
