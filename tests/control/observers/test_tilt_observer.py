"""What turns a vehicle beside its commanded roll and pitch is found, and what is known to turn it is not counted twice."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.observers.tilt_observer import TiltObserver
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.scenario import ControlSection

STEP = 0.005


def offset_found(moved: float, known: float, seconds: float, gain: float = 10.0) -> float:
    """Offset of pitch that is found where a commanded swing of the pitch settles beside the command."""
    loop = AttitudeLoop(1.0 / gain)
    observer, tilt, rate = TiltObserver(loop, 0.25), 0.0, 0.0
    for k in range(round(seconds / STEP)):
        commanded = 0.1 * np.sin(3.0 * k * STEP)
        rate += STEP * 2.8 * gain * (gain * (commanded + moved - tilt) - rate)
        tilt += STEP * rate
        observer.update(np.array([0.0, tilt]), np.array([0.0, commanded]), np.array([0.0, known]), STEP)
    assert observer.offset[0] == 0.0
    return float(observer.offset[1])


@pytest.mark.parametrize("gain", [6.0, 10.0, 14.0])
@pytest.mark.parametrize("moved", [-0.07, 0.0, 0.05])
def test_what_turns_the_vehicle_is_found(moved: float, gain: float) -> None:
    assert offset_found(moved, 0.0, 12.0 / gain, gain) == pytest.approx(moved, abs=3e-3)


def test_what_is_known_to_turn_it_is_no_offset() -> None:
    assert offset_found(0.05, 0.05, 1.2) == pytest.approx(0.0, abs=3e-3)
    assert offset_found(0.0, 0.05, 1.2) == pytest.approx(-0.05, abs=3e-3), "an autopilot's integrator has taken it up"


def test_a_slow_loop_is_watched_as_fast_as_integrators_act() -> None:
    assert offset_found(0.05, 0.0, 1.0, gain=3.0) == pytest.approx(0.05, abs=5e-3)


def test_it_is_bounded_and_forgotten() -> None:
    assert offset_found(0.6, 0.0, 3.0) == pytest.approx(0.5 * ControlSection().max_tilt)
    observer = TiltObserver(AttitudeLoop(0.1), 0.25)
    for _ in range(50):
        observer.update(np.array([0.0, 0.1 * _]), np.zeros(2), np.zeros(2), STEP)
    observer.forget()
    assert not observer.offset.any()
