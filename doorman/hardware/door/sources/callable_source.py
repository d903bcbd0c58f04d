"""Readings of the door from a callable: an encoder's driver, a simulator, a laboratory's own program."""

from __future__ import annotations

from collections.abc import Callable

from doorman.copying import Uncopied
from doorman.hardware.door.sample import DoorSample


class CallableSource(Uncopied):
    """Asks a callable at every tick; it must answer at once.

    Args:
        read: Returns the newest sample.
    """

    def __init__(self, read: Callable[[], DoorSample]) -> None:
        self._read = read

    def open(self) -> None:
        """Do nothing: the callable is ready."""

    def read(self) -> DoorSample:
        """Newest sample."""
        return self._read()

    def stop(self) -> None:
        """Do nothing."""
