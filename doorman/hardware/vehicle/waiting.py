"""Waiting for links that were just opened: until the autopilot may fly, and rates and clocks have been measured."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from doorman.clocks import LOOK
from doorman.hardware.mocap import PoseSample
from doorman.hardware.pixhawk import SampleStatus
from doorman.hardware.pixhawk.sample import VehicleSample
from doorman.hardware.vehicle.links import VehicleLinks
from doorman.kinematics.quaternions import angle_between, rotate

SETTLING = 2.0
"""Time for rates and clocks to settle; a wait that is longer is explained [s]."""
LISTENING = SETTLING / 2
"""Time of which the mean of readings counts, the vehicle at rest [s]."""
TOGETHER = 0.1
"""Distance between mocap and the autopilot's estimate from which it does not follow the poses [m]."""


def await_links(links: VehicleLinks, say: Callable[[str], None] | None = None) -> None:
    clock = links.clock
    begin, said, patience = clock.now(), "", links.config.pixhawk.timeouts.arming
    while True:
        while (missing := _missing(links)) and clock.now() < begin + patience:
            if say is not None and missing != said and clock.now() > begin + SETTLING:
                say(f"Waiting for {missing}")
                said = missing
            clock.sleep(LOOK)
        clock.sleep(SETTLING)
        if not _missing(links) or clock.now() > begin + patience:
            return  # what an autopilot has not reported at first, it may find wrong now: once more then


def _missing(links: VehicleLinks) -> str:
    """What an autopilot comes round to by itself has not come yet; empty if nothing is missing."""
    state = links.autopilot.state()
    if state.status is not SampleStatus.FRESH:
        return "the autopilot's position"
    if not apart(links) <= TOGETHER:
        return "the autopilot to follow mocap's poses"
    if state.ready_to_arm is False:
        return "the autopilot's own checks"
    return ""


def apart(links: VehicleLinks) -> float:
    """Distance between mocap's pose and the autopilot's estimate [m]; 0 without mocap, NaN without a pose that can be used."""
    return _compared(links, lambda seen, own: float(np.linalg.norm(seen.position - own.position)))


def turned(links: VehicleLinks) -> float:
    """Angle between mocap's attitude and the autopilot's estimate [rad]; 0 without mocap, NaN without a pose that can be used."""
    return _compared(links, lambda seen, own: angle_between(seen.quaternion.tolist(), own.quaternion.tolist()))


def leaning(links: VehicleLinks) -> float:
    """Angle between the two attitudes' upward axes [rad]. 0 without mocap, NaN without a usable pose."""
    return _compared(links, lambda seen, own: tilt_between(seen.quaternion, own.quaternion))


def tilt_between(a: NDArray[np.float64], b: NDArray[np.float64]) -> float:
    """Angle between the body's z axes of two attitudes [rad]."""
    up = (0.0, 0.0, 1.0)
    return math.acos(min(max(float(np.dot(rotate(a.tolist(), up), rotate(b.tolist(), up))), -1.0), 1.0))


def _compared(links: VehicleLinks, differ: Callable[[PoseSample, VehicleSample], float]) -> float:
    """How mocap's pose differs from the autopilot's estimate; 0 without mocap, NaN without a pose that can be used."""
    if links.mocap is None:
        return 0.0
    pose = links.mocap.read()
    return differ(pose, links.autopilot.state()) if pose.usable else math.nan
