"""Commands under way: the prediction against plain integration, and the margins that it gives the loop of position."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.control.under_way import UnderWay
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.gravity import GRAVITY
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.scenario import ControlSection

MASS, TICK = 3.0, 0.004
BELIEVED = AttitudeLoop(0.16, 0.06)
LEVEL = np.zeros(3)


def flown(loop: AttitudeLoop, commands: np.ndarray, step: float = 2e-4) -> tuple[np.ndarray, np.ndarray]:
    """Pitch and its rate at every tick of a vehicle that is told a pitch a tick."""
    pitch = rate = 0.0
    found, each = [], round(TICK / step)
    for k in range(len(commands) * each):
        if k % each == 0:
            found.append((pitch, rate))
        sent = math.floor((k * step - loop.dead_time + 1e-9) / TICK)
        commanded = float(commands[sent]) if sent >= 0 else 0.0
        rate += step * loop.rate_gain * (loop.gain * (commanded - pitch) - rate)
        pitch += step * rate
    return np.array([one[0] for one in found]), np.array([one[1] for one in found])


@pytest.mark.parametrize("yaw", [0.0, 1.1])
def test_prediction_is_what_the_model_does(yaw: float) -> None:
    """By commands that are known until then; of a vehicle at another heading, turned."""
    horizon = BELIEVED.dead_time + BELIEVED.lag
    after = round(horizon / TICK)
    commands = np.concatenate(
        [0.1 * np.sin(9.0 * TICK * np.arange(100)), np.full(after, 0.1 * math.sin(9.0 * TICK * 99))]
    )
    pitch, rate = flown(BELIEVED, commands)
    under_way = UnderWay(BELIEVED, MASS)
    for k in range(100):
        under_way.note(k * TICK, np.array([0.0, commands[k], yaw]))
    attitude, rates = np.array([0.0, pitch[99], yaw]), np.array([0.0, rate[99], 0.0])
    velocity, outer = np.array([0.2, -0.1, 0.3]), np.array([0.6, 0.0, 0.0])
    rotors = np.array([0.0, 0.0, MASS * GRAVITY])
    later = under_way.later(99 * TICK, attitude, rates, velocity, rotors, outer)
    ahead = np.array([math.cos(yaw), math.sin(yaw)])
    gained = GRAVITY * TICK * np.sin(pitch[99 : 99 + after])
    expected = gained.sum() * ahead + horizon * outer[:2] / MASS
    assert later.gained[:2] == pytest.approx(expected, abs=0.02)
    assert later.moved[2] == later.gained[2] == 0.0, "thrust has no lag"
    assert later.moved[:2] == pytest.approx(
        horizon * velocity[:2] + TICK * np.cumsum(gained).sum() * ahead + 0.5 * horizon**2 * outer[:2] / MASS, abs=3e-3
    )


def test_a_command_that_has_not_been_sent_long_enough_does_nothing_yet() -> None:
    under_way = UnderWay(AttitudeLoop(0.16, 0.3), MASS)
    under_way.note(0.0, LEVEL)
    under_way.note(1.0, np.array([0.0, 0.2, 0.0]))
    rotors = np.array([0.0, 0.0, MASS * GRAVITY])
    soon = under_way.later(1.0, LEVEL, LEVEL, LEVEL, rotors, LEVEL)
    assert 0.0 < soon.gained[0] < 0.16 * GRAVITY * 0.1
    under_way.fly_by(AttitudeLoop(0.1, 0.3))
    assert under_way.later(0.65, LEVEL, LEVEL, LEVEL, rotors, LEVEL).gained[0] == pytest.approx(0.0, abs=1e-9)


def hover_error(true: AttitudeLoop, believed: AttitudeLoop | None, gain: float = 1.0) -> float:
    """Where a vehicle is that was 5 cm off its place 4 s ago, in the position controller's loop along x, at most [m]."""
    settings = ControlSection()
    stiffness, damping = settings.position_gain[0], settings.velocity_gain[0]
    under_way = UnderWay(believed or AttitudeLoop(0.1), MASS)
    position, velocity, pitch, rate = 0.05, 0.0, 0.0, 0.0
    sent: list[float] = []
    step, worst = TICK / 4, 0.0
    rotors = np.array([0.0, 0.0, MASS * GRAVITY])
    for tick in range(1500):
        moved = gained = 0.0
        if believed is not None:
            attitude, rates = np.array([0.0, pitch, 0.0]), np.array([0.0, rate, 0.0])
            later = under_way.later(tick * TICK, attitude, rates, np.array([velocity, 0.0, 0.0]), rotors, LEVEL)
            moved, gained = float(later.moved[0]), float(later.gained[0])
        wanted = -gain * (stiffness * (position + moved) + damping * (velocity + gained)) / GRAVITY
        sent.append(min(max(wanted, -0.25), 0.25))
        under_way.note(tick * TICK, np.array([0.0, sent[-1], 0.0]))
        for part in range(4):
            at = math.floor(tick + part / 4 - true.dead_time / TICK + 1e-9)
            commanded = sent[at] if at >= 0 else 0.0
            rate += step * true.rate_gain * (true.gain * (commanded - pitch) - rate)
            pitch += step * rate
            velocity += step * float(rotation_body_to_world([0.0, pitch, 0.0])[0, 2]) * GRAVITY
            position += step * velocity
        if tick > 1000:
            worst = max(worst, abs(position))
    return worst


@pytest.mark.parametrize(("lag", "dead"), [(1.0, 0.0), (1.4, 0.04), (0.6, -0.04), (1.4, -0.04), (0.6, 0.04)])
def test_a_wrong_belief_costs_accuracy_not_stability(lag: float, dead: float) -> None:
    """Lag off by 40 %, dead time by 40 ms, and on top of that twice the gain: a margin of 6 dB."""
    true = AttitudeLoop(lag * BELIEVED.lag, BELIEVED.dead_time + dead)
    assert hover_error(true, BELIEVED) < 2e-3
    assert hover_error(true, BELIEVED, gain=2.0) < 5e-3
