"""Flying to a place by the autopilot's own position control, without planner and controller."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from doorman.hardware.pixhawk import Authority, Autopilot, PositionSetpoint

Array = NDArray[np.float64]

SPEED = 0.4
"""Of the setpoint [m/s]."""
_TURN_RATE = 0.5
"""Of the setpoint [rad/s]."""
_NEAR = 0.06
"""Distance that counts as arrived [m]."""
_CALM = 0.1
"""Speed that counts as arrived [m/s]."""
_PERIOD = 0.02


def fly_to(autopilot: Autopilot, place: Array, yaw: float, timeout: float = 20.0) -> bool:
    """Stream position setpoints along a straight line, at `SPEED`, until the vehicle has arrived.

    Args:
        autopilot: Engaged, in the air.
        place: Of O_B, shape (3,), world frame [m].
        yaw: Heading [rad].
        timeout: [s].

    Returns:
        Whether it arrived; False too if the vehicle is not ours any more, or is landing.
    """
    state = autopilot.state()
    begin, turn = state.position, (yaw - float(state.attitude[2]) + np.pi) % (2.0 * np.pi) - np.pi
    way = place - begin
    duration = max(float(np.linalg.norm(way)) / SPEED, abs(turn) / _TURN_RATE, _PERIOD)
    started = time.monotonic()
    while (passed := time.monotonic() - started) < timeout + duration:
        share = min(passed / duration, 1.0)
        velocity = way / duration if share < 1.0 else np.zeros(3)
        if not autopilot.setpoint(PositionSetpoint(begin + share * way, yaw - (1.0 - share) * turn, velocity)):
            return False
        if autopilot.status().authority is not Authority.ENGAGED:
            return False
        state = autopilot.state()
        near = np.linalg.norm(state.position - place) < _NEAR and np.linalg.norm(state.velocity) < _CALM
        if share == 1.0 and near:
            return True
        time.sleep(_PERIOD)
    return False
