"""Source: what brings samples of one kind, whoever measures them. Anybody can implement one."""

from __future__ import annotations

from typing import Protocol, TypeVar, runtime_checkable

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
