"""Pose source: what brings the body's pose, whoever measures it."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from doorman.hardware.mocap.poses.sample import PoseSample


@runtime_checkable
class PoseSource(Protocol):
    """Three methods. `MocapReceiver` has them for every kind of `connection`.

    A source judges what it brings: `PoseSample` says how old the pose is, whether it was measured, and what is wrong.
    """

    def open(self) -> None:
        """Begin to receive, and wait for a steady pose.

        Raises:
            BackendError: if none comes in time; it says what comes instead.
        """

    def read(self) -> PoseSample:
        """Newest pose, at once, with its age as of the call."""

    def stop(self) -> None:
        """End it; may be called twice."""
