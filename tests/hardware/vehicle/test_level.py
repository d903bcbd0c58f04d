"""Roll and pitch by cameras and by the autopilot: compared without the heading."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.hardware.quaternions import from_attitude
from doorman.hardware.vehicle.waiting import tilt_between


def attitude(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Quaternion of Euler angles [deg]."""
    return np.array(from_attitude(np.radians([roll, pitch, yaw])))


@pytest.mark.parametrize("yaw", [0.0, 17.0, 180.0])
def test_a_heading_is_no_tilt(yaw: float) -> None:
    assert tilt_between(attitude(0.0, 0.0, 0.0), attitude(0.0, 0.0, yaw)) == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize(("roll", "pitch"), [(4.0, 0.0), (0.0, -4.0)])
def test_a_tilted_object_is_seen_at_any_heading(roll: float, pitch: float) -> None:
    level, tilted = attitude(0.0, 0.0, 40.0), attitude(roll, pitch, 40.0)
    assert math.degrees(tilt_between(level, tilted)) == pytest.approx(4.0, abs=1e-6)
    assert math.degrees(tilt_between(-tilted, level)) == pytest.approx(4.0, abs=1e-6)
