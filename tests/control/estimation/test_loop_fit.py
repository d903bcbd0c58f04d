"""Lag and dead time are found from small steps with noise, with deviations that hold."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.estimation.loop_fit import LoopFit, MeasuredLoop, lateness
from doorman.dynamics.attitude_loop import AttitudeLoop

DURATION = 4.0


def measured(loops: tuple[AttitudeLoop, AttitudeLoop], noise: float, rate: float, seed: int = 1) -> MeasuredLoop:
    """What steps of 1.7° find of two axes whose trim is off and drifts; poses come at every other tick."""
    random, tick, inner = np.random.default_rng(seed), 1.0 / rate, 8
    fit, tilt, rates = LoopFit(DURATION, rate), np.zeros(2), np.zeros(2)
    sent: list[np.ndarray] = []
    for k in range(round(DURATION * rate)):
        now = k * tick
        off = np.array([0.01, -0.02]) + 0.001 * now
        seen = tilt + off + noise * random.standard_normal(2)
        phase = np.array([(now - 0.25) / 0.4, (now - 1.85) / 0.4])
        active = (phase > 0.0) & (phase < 4.0)
        sent.append(np.where(active, np.where((phase + 0.5) % 2.0 < 1.0, 0.03, -0.03), 0.0))
        fit.note(now, sent[-1] + off, seen, tick * (k - k % 2))
        for part in range(inner):
            for axis, loop in enumerate(loops):
                at = int(np.floor(k + (part + 0.5) / inner - loop.dead_time * rate))
                commanded = sent[at][axis] if at >= 0 else 0.0
                rates[axis] += tick / inner * loop.rate_gain * (loop.gain * (commanded - tilt[axis]) - rates[axis])
                tilt[axis] += tick / inner * rates[axis]
    found = fit.fitted()
    assert found is not None
    return found


@pytest.mark.parametrize("rate", [100.0, 250.0])
@pytest.mark.parametrize("loop", [AttitudeLoop(0.03, 0.08), AttitudeLoop(0.17, 0.05), AttitudeLoop(0.3, 0.0)])
def test_lag_and_dead_time_of_both_axes(loop: AttitudeLoop, rate: float) -> None:
    other = AttitudeLoop(1.3 * loop.lag, loop.dead_time + 0.02)
    found = measured((loop, other), 0.002, rate)
    for axis, true in enumerate((loop, other)):
        assert found.lag[axis] == pytest.approx(true.lag, abs=0.008 + 0.11 * true.lag)
        assert found.dead_time[axis] == pytest.approx(true.dead_time, abs=0.021)
        late = found.lag[axis] + found.dead_time[axis]
        assert late == pytest.approx(true.lag + true.dead_time, abs=0.008 + 0.05 * true.lag)
    assert (found.explained > 0.8).all()
    assert found.loop.lag == pytest.approx(found.lag.mean())


def test_deviations_grow_with_the_noise_and_hold() -> None:
    loop = AttitudeLoop(0.15, 0.06)
    quiet, loud = measured((loop, loop), 0.001, 250.0), measured((loop, loop), 0.007, 250.0)
    assert (loud.lag_deviation > quiet.lag_deviation).all()
    assert (np.abs(loud.lag - loop.lag) < 4.0 * loud.lag_deviation + 0.008).all()


def test_nothing_is_found_of_what_was_not_seen() -> None:
    assert LoopFit(DURATION, 250.0).fitted() is None


@pytest.mark.parametrize("late", [0.0, 0.014, 0.03])
def test_how_late_body_rates_come(late: float) -> None:
    random, poses, ticks = np.random.default_rng(3), np.arange(0.0, 3.7, 0.01), np.arange(0.0, 3.75, 0.005)

    def attitude(time: np.ndarray) -> np.ndarray:
        return 0.03 * np.stack([np.sin(7.0 * time), np.cos(9.0 * time)], axis=1)

    seen = attitude(poses) + 5e-4 * random.standard_normal((len(poses), 2))
    rates = (attitude(ticks - late + 1e-3) - attitude(ticks - late - 1e-3)) / 2e-3
    assert lateness(poses, seen, ticks, rates) == pytest.approx(late, abs=0.003)


@pytest.mark.parametrize("ratio", [1.4, 2.8])
def test_the_shape_is_found_where_it_can_be_told(ratio: float) -> None:
    """A loop that overshoots passes for one of less lag and more dead time where its shape is taken for the usual one."""
    loop = AttitudeLoop(0.15, 0.06, ratio=ratio)
    found = measured((loop, loop), 0.005, 250.0)
    assert found.ratio == pytest.approx(ratio, rel=0.3)
    assert found.lag == pytest.approx([loop.lag] * 2, rel=0.15)
    assert found.loop.stiffness == pytest.approx(loop.stiffness, rel=0.35)
