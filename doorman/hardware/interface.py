"""Backend: what the mission loop flies, be it a simulator or a vehicle; nothing in the loop knows which. Sources of samples."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Protocol, TypeVar, runtime_checkable

from doorman.background import Opened
from doorman.signals import Command as Command
from doorman.signals import Measurement as Measurement

Sample_co = TypeVar("Sample_co", covariant=True)


@runtime_checkable
class Source(Protocol[Sample_co]):
    """Three methods: poses of the vehicle come so (`PoseSource`), and readings of the door (`DoorSource`)."""

    def open(self) -> None:
        """Begin to receive; a source of poses waits for a steady one."""

    def read(self) -> Sample_co:
        """Newest sample, at once."""

    def stop(self) -> None:
        """End it; may be called twice."""


class Backend(Opened, ABC):
    """A vehicle with an arm, simulated or real. Constructors touch no device: `open` does, and `with` always stops."""

    real_time: bool = False
    """Whether the plant goes on while the mission computes: plans are made in a thread of their own then."""
    comes_back: bool = False
    """Whether the vehicle lands after the mission, and so leaves in the end even a door that would not stay by itself."""

    @property
    def feedback_lag(self) -> float:
        """Lag of the attitude loop's feedback, where feed-forward makes it follow commands sooner [s]; 0 if it has none."""
        return 0.0

    @abstractmethod
    def open(self) -> None:
        """Start the plant or connect the links; `read` may be called from here on.

        Raises:
            BackendError: if it cannot be opened.
        """

    @abstractmethod
    def read(self) -> Measurement:
        """Wait for the next tick of the controller and return what the sensors say then.

        Raises:
            BackendError: if no valid measurement arrives in time.
        """

    @abstractmethod
    def command(self, command: Command) -> None:
        """Send a command; it holds until the next one.

        Args:
            command: Thrust, attitude and joint rates.

        Raises:
            BackendError: if the command is not finite or cannot be sent.
        """

    @abstractmethod
    def stop(self) -> None:
        """Stop the arm and let go of every device; may be called twice."""

    def watch_mission(self, abort: Callable[[str], None]) -> None:  # noqa: B027 - most have nothing to ask
        """Take how the mission, which calls this before it opens the backend, is asked to leave the door and come back.

        Args:
            abort: To be called with the reason, from any thread.
        """
