"""Pose source: what brings the body's pose, whoever measures it."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from doorman.hardware.mocap.poses.sample import PoseSample
from doorman.hardware.source import Source


@runtime_checkable
class PoseSource(Source[PoseSample], Protocol):
    """`MocapReceiver` is one for every kind of `connection`.

    It judges what it brings: `PoseSample` says how old the pose is, whether it was measured, and what is wrong.
    """
