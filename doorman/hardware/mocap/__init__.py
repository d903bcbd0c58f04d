"""Mocap: the body's pose from a Vicon Tracker UDP object stream."""

from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.faults import DISCARDING, MocapEvent, MocapFault
from doorman.hardware.mocap.figures import MocapStatistics
from doorman.hardware.mocap.receiver import MocapReceiver
from doorman.hardware.mocap.sample import PoseQuality, PoseSample

__all__ = [
    "DISCARDING",
    "MocapConfig",
    "MocapEvent",
    "MocapFault",
    "MocapReceiver",
    "MocapStatistics",
    "PoseQuality",
    "PoseSample",
]
