"""Source: what brings samples of one kind, whoever measures them. Anybody can implement one."""

from __future__ import annotations

from typing import Protocol, TypeVar, runtime_checkable

Sample_co = TypeVar("Sample_co", covariant=True)


@runtime_checkable
class Source(Protocol[Sample_co]):
    """Three methods: poses of the vehicle come so (`PoseSource`), and readings of the door (`DoorSource`).

    A source says of each sample when it was true, by `time.monotonic`. Who reads it judges what else is wrong.
    """

    def open(self) -> None:
        """Begin to receive; a source of poses waits for a steady one.

        Raises:
            BackendError: if that cannot be; it says what comes instead.
        """

    def read(self) -> Sample_co:
        """Newest sample, at once."""

    def stop(self) -> None:
        """End it; may be called twice."""
