"""Flying to a place by the autopilot's own position control, without planner and controller."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from doorman.arrays import Array
from doorman.hardware.pixhawk import Authority
from doorman.hardware.pixhawk.setpoints import SPEED, StraightWay
from doorman.hardware.vehicle import VehicleLinks

_NEAR = 0.06
"""Distance that counts as arrived [m]."""
_CALM = 0.1
"""Speed that counts as arrived [m/s]."""
_UNKNOWN = 0.5
"""After the setpoint's arrival, the vehicle counts as arrived, too, if its position was unknown for so long [s]."""
_PERIOD = 0.02


def fly_to(
    links: VehicleLinks,
    place: Array,
    yaw: float,
    timeout: float = 20.0,
    go_on: Callable[[], bool] = lambda: True,
    begin: Array | None = None,
    speed: float = SPEED,
) -> bool:
    """Stream position setpoints along a `StraightWay` until the vehicle has arrived."""
    autopilot, where = links.autopilot, links.whereabouts()
    here = where.position if where.known or begin is None else begin
    way = StraightWay(links.clock.now(), here, place, where.yaw, yaw, speed)
    end = known = way.since + way.duration
    while (now := links.clock.now()) < end + timeout:
        if not go_on() or not autopilot.setpoint(way.setpoint(now)):
            return False
        if autopilot.status().authority is not Authority.ENGAGED:
            return False
        where = links.whereabouts()
        near = np.linalg.norm(where.position - place) < _NEAR and np.linalg.norm(where.velocity) < _CALM
        known = max(known, now) if where.known else known
        if now >= end and (near if where.known else now - known > _UNKNOWN):
            return True
        links.clock.sleep(_PERIOD)
    return False
