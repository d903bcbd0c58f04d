"""Emulated Trackers on loopback, each with a receiver."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest
from mocap_rig import Rig, start_rig


@contextmanager
def rigs() -> Iterator[Callable[..., Rig]]:
    """Makes rigs, and ends them."""
    made: list[Rig] = []

    def make(**options: Any) -> Rig:
        made.append(start_rig(**options))
        return made[-1]

    yield make
    for rig in made:
        rig.receiver.stop()
        rig.emulator.stop()


@pytest.fixture
def make_rig() -> Iterator[Callable[..., Rig]]:
    """A running emulator and a receiver that is not open; options as of `start_rig`."""
    with rigs() as make:
        yield make


@pytest.fixture
def own_rig(make_rig: Callable[..., Rig]) -> Rig:
    """An open receiver of the test's own, for faults that leave traces."""
    made = make_rig()
    made.receiver.open()
    return made


@pytest.fixture(scope="module")
def shared_rig() -> Iterator[Rig]:
    """An open receiver for all tests of a module: opening takes a third of a second."""
    with rigs() as make:
        made = make()
        made.receiver.open()
        yield made


@pytest.fixture
def rig(shared_rig: Rig) -> Iterator[Rig]:
    """The shared receiver, with everything well and nothing noted."""
    shared_rig.settle()
    yield shared_rig
    shared_rig.heal()
