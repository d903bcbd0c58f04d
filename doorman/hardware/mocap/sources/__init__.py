"""Other cameras than Vicon Tracker's: their clients run in processes of their own and send the stream that the receiver reads."""

from doorman.hardware.mocap.sources.sender import PoseSender
from doorman.hardware.mocap.sources.source import PoseSource

__all__ = ["PoseSender", "PoseSource"]
