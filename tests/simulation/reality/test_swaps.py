"""Markers that are taken for others: how often, for how long, by how much, and what the cameras then say."""

from __future__ import annotations

import numpy as np
import pytest
from quiet_noise import quiet_noise

from doorman.scenario import SensorsSection
from doorman.simulation.reality.seen_frame import Swaps
from doorman.simulation.sensors import Sensors
from doorman.simulation.truth import Truth

SECTION = SensorsSection(swap_rate=0.5)
TICK = 0.01


def test_swaps_come_as_often_last_as_long_and_are_as_large_as_said() -> None:
    swaps = Swaps(SECTION, 3)
    off = np.array([swaps.off(TICK * k) for k in range(400_000)])
    swapped = off.any(axis=1)
    begins = np.flatnonzero(np.diff(swapped.astype(int)) == 1)
    assert swapped.mean() == pytest.approx(0.4 / 2.4, rel=0.1), "0.4 s on average, after 2 s without"
    np.testing.assert_allclose(np.linalg.norm(off[swapped, :3], axis=1), 0.02)
    np.testing.assert_allclose(np.linalg.norm(off[swapped, 3:], axis=1), 0.026)
    directions = off[begins + 1, :3] / 0.02
    assert np.abs(directions.mean(axis=0)).max() < 0.1 and len(begins) == pytest.approx(4000 / 2.4, rel=0.1)


def test_a_swap_moves_what_the_cameras_say_and_nothing_else() -> None:
    sensors, swaps, seen = Sensors(quiet_noise(), 3, SECTION), Swaps(SECTION, 3), 0
    for k in range(2000):
        truth = Truth(
            time=TICK * k, position=np.ones(3), velocity=np.zeros(3), attitude=np.zeros(3), body_rates=np.zeros(3),
            door_angle=1.0, door_rate=0.0, arm_angles=np.zeros(1), arm_rates=np.zeros(1), tip_force=np.zeros(3),
            tip_normal_force=0.0, touching=False, max_pull=0.0, collisions=0, collision_pairs=(), only_tip_on_frame=False,
            rotor_thrusts=np.zeros(4),
        )  # fmt: skip
        measured, off = sensors.measure(truth), swaps.off(TICK * k)
        np.testing.assert_allclose(measured.position, 1.0 + off[:3])
        np.testing.assert_allclose(measured.attitude, off[3:])
        assert not measured.velocity.any() and not measured.body_rates.any()
        seen += off.any()
    assert seen > 50
