"""The frame of the poses: it jumps as often and as far as it is told to, slides and turns, and the truth stays."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.scenario import NoiseSection, SensorsSection
from doorman.simulation import SimulatedBackend
from doorman.simulation.reality.seen_frame import SeenFrame, seen_frame

PLACE = np.array([1.0, -2.0, 0.5])


def seen(section: SensorsSection, seed: int, times: np.ndarray) -> np.ndarray:
    frame = SeenFrame(section, seed)
    found = []
    for time in times:
        frame.advance(float(time))
        found.append(frame.position(PLACE))
    return np.array(found)


def test_by_default_there_is_none():
    assert seen_frame(SensorsSection(), 0) is None
    assert seen_frame(SensorsSection(jump=0.1), 0) is None, "without a rate it never jumps"


def test_it_jumps_at_its_rate_by_its_deviation():
    path = seen(SensorsSection(jump_rate=0.5, jump=0.02), 4, np.arange(0.0, 2000.0, 0.05))
    steps = np.flatnonzero(np.abs(np.diff(path, axis=0)).max(axis=1))
    assert len(steps) == pytest.approx(1000, rel=0.12)
    np.testing.assert_allclose((path[steps + 1] - PLACE).std(axis=0), 0.02, rtol=0.12)
    np.testing.assert_array_equal(path[0], PLACE)


def test_it_slides_straight_and_turns():
    times = np.array([0.0, 5.0, 10.0])
    moved = seen(SensorsSection(drift=0.003), 7, times) - PLACE
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), 0.003 * times)
    np.testing.assert_allclose(moved[2], 2.0 * moved[1])
    frame = SeenFrame(SensorsSection(turn_rate=0.01), 7)
    frame.advance(20.0)
    cosine, sine = math.cos(0.2), math.sin(0.2)
    np.testing.assert_allclose(frame.position(PLACE), [cosine + 2 * sine, sine - 2 * cosine, 0.5])
    np.testing.assert_allclose(frame.attitude(np.array([0.1, 0.2, 0.3])), [0.1, 0.2, 0.5])


def test_the_seed_makes_it_and_the_poses_show_it(model):
    quiet = {f"simulation__noise__{name}": 0.0 for name in NoiseSection.model_fields}
    scene = model(mission__start="hover", simulation__sensors__drift=0.05, **quiet)

    def error(seed: int) -> np.ndarray:
        with SimulatedBackend(scene, seed) as backend:
            for _ in range(51):
                measurement = backend.read()
            return np.asarray(measurement.position - backend.truth.position)

    first = error(1)
    assert np.linalg.norm(first) == pytest.approx(0.05 * 0.2)
    np.testing.assert_array_equal(first, error(1))
    assert not np.allclose(first, error(2))
