"""Mocap: the body's pose from cameras: Vicon Tracker's UDP object stream, OptiTrack, Qualisys, VRPN, Vicon DataStream."""

from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.faults import DISCARDING, MocapEvent, MocapFault, MocapStatistics
from doorman.hardware.mocap.receiver import MocapReceiver
from doorman.hardware.mocap.sample import PoseQuality, PoseSample, PoseSource
from doorman.hardware.mocap.sources.sender import PoseSender

__all__ = [
    "DISCARDING",
    "MocapConfig",
    "MocapEvent",
    "MocapFault",
    "MocapReceiver",
    "MocapStatistics",
    "PoseQuality",
    "PoseSample",
    "PoseSender",
    "PoseSource",
]
