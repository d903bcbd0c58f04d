"""What parts of the adapter are tested with, each alone and with time made up."""

from __future__ import annotations

import numpy as np
from pixhawk_rig import NO

from doorman.hardware.pixhawk import PixhawkConfig, ThrustCurve, VehicleSample

CONFIG = PixhawkConfig("udp:14540", thrust_curve=ThrustCurve(0.4, 30.0))
TARGET = (1, 1)


def sample(**changes) -> VehicleSample:
    values = {"position": np.array([1.0, 2.0, 3.0]), "attitude": np.array([0.1, 0.0, 0.5]), "velocity": NO,
              "attitude_time": 10.0, "position_time": 10.0, "heartbeat_time": 10.0}  # fmt: skip
    return VehicleSample(**{**values, **changes})
