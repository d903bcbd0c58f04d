"""The pose of a door from touches of its frame and from a sensor, against doors that stand elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.estimation.door_place import DoorPlace, turned
from doorman.estimation.status import Status

INTO, ALONG = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
FACES = [
    (np.array([-0.1, 1.6, 0.8]), INTO),
    (np.array([-0.1, -0.5, 0.8]), INTO),
    (np.array([-0.07, 0.0, 0.8]), -ALONG),
]
"""Places from the hinge, and their normals."""
PLACE, YAW, NOISE = 0.015, 0.026, 0.003
Array = np.ndarray


def tips(offset: Array, yaw: float, slip: float = 0.0) -> list[Array]:
    """Where the tip is at a door that stands elsewhere; it slips along each face."""
    turn, there = turned(yaw), np.array([*offset, 0.0])
    return [turn @ (point + slip * np.array([-normal[1], normal[0], 0.0])) + there for point, normal in FACES]


def touched(place: DoorPlace, at: list[Array], times: tuple[float, ...] = (0.0, 10.0, 20.0)) -> DoorPlace:
    for time, tip, (point, normal) in zip(times, at, FACES, strict=False):
        assert place.touched(time, tip, point, normal) == Status.OK
    return place


@pytest.mark.parametrize("offset, yaw", [((0.02, -0.03), 0.05), ((-0.01, 0.02), -0.04), ((0.0, 0.0), 0.0)])
def test_three_touches_find_the_door(offset: tuple[float, float], yaw: float) -> None:
    place = touched(DoorPlace(1.0, 1.0, touch=1e-4), tips(np.array(offset), yaw, slip=0.02))
    np.testing.assert_allclose(place.offset, offset, atol=1e-4)
    assert place.yaw == pytest.approx(yaw, abs=1e-4)
    for tip, (point, normal) in zip(tips(np.array(offset), yaw), FACES, strict=True):
        assert (place.turn @ normal) @ (place.placed(point) - tip) == pytest.approx(0.0, abs=2e-4)


def test_two_touches_of_the_front_say_nothing_of_the_place_along_it() -> None:
    place = touched(DoorPlace(PLACE, YAW), tips(np.array([0.02, 0.0]), 0.02)[:2])
    assert place.offset[0] == pytest.approx(0.02, abs=0.003) and place.yaw == pytest.approx(0.02, abs=0.002)
    deviations = np.sqrt(np.diag(place.covariance))
    assert deviations[1] == pytest.approx(PLACE, rel=0.01) and deviations[2] < 0.1 * YAW


def test_without_a_touch_the_map_is_all_that_is_known() -> None:
    place = DoorPlace(PLACE, YAW)
    assert not place.offset.any() and place.yaw == 0.0 and not place.found
    np.testing.assert_allclose(np.diag(place.covariance), np.array([PLACE, PLACE, YAW]) ** 2)
    assert place.deviation(*FACES[0]) == pytest.approx(math.hypot(PLACE, 1.6 * YAW), rel=1e-6)


WALK = 0.002
"""So much that it outweighs the noise of touches [m/s^½]."""


@pytest.mark.parametrize("walk", [0.0, WALK])
def test_the_covariance_is_that_of_many_flights_in_a_frame_that_walks(walk: float, rng: np.random.Generator) -> None:
    """Normalised errors squared: as many as there are numbers, on average."""
    times, later, squares = (0.0, 10.0, 25.0), 60.0, []
    for _ in range(40):
        offset, yaw = rng.normal(0.0, PLACE, 2), float(rng.normal(0.0, YAW))
        steps = np.sqrt(np.diff([*times, later]))[:, None] * walk * rng.normal(size=(3, 2))
        walked = np.cumsum([np.zeros(2), *steps], axis=0)
        noisy = [
            tip + rng.normal(0.0, NOISE, 3) + np.array([*by, 0.0])
            for tip, by in zip(tips(offset, yaw), walked, strict=False)
        ]
        place = touched(DoorPlace(PLACE, YAW, walk=walk, touch=NOISE), noisy, times)
        off = [np.array([*(place.offset - offset - by), place.yaw - yaw]) for by in walked[2:]]
        squares.append([
            each @ np.linalg.solve(covariance, each)
            for each, covariance in zip(off, (place.covariance, place.covariance_at(later)), strict=True)
        ])  # fmt: skip
    assert ((np.mean(squares, axis=0) > 2.0) & (np.mean(squares, axis=0) < 4.2)).all(), np.mean(squares, axis=0)


def test_a_sensor_is_believed_at_once_and_then_averaged(rng: np.random.Generator) -> None:
    """Its door stands farther from the map than that was doubted."""
    place, there, yaw = DoorPlace(PLACE, YAW), np.array([0.09, -0.07]), 0.1
    for k in range(300):
        seen, turn = there + rng.normal(0.0, 0.01, 2), yaw + float(rng.normal(0.0, 0.01))
        assert place.seen(k / 30.0, seen, turn, (0.01, 0.01)) == Status.OK
        if k == 0:
            np.testing.assert_allclose(place.offset, seen)
    assert place.found
    off = np.array([*(place.offset - there), place.yaw - yaw])
    deviations = np.sqrt(np.diag(place.covariance))
    assert (deviations < 0.003).all() and (np.abs(off) < 3.0 * deviations).all()


def test_a_tip_that_slips_off_its_circle_is_refused() -> None:
    place, radius = DoorPlace(PLACE, YAW), 0.7
    place.met(0.0, np.array([0.0, radius]), 0.0)
    for k in range(30):
        angle = math.pi / 2 - 0.03 * k
        assert place.goes_round(0.1 + 0.1 * k, radius * np.array([math.cos(angle), math.sin(angle)])) == Status.OK
    before = place.offset
    assert place.goes_round(4.0, (radius + 0.05) * np.array([1.0, 0.0])) == Status.REFUSED
    np.testing.assert_allclose(place.offset, before, atol=1e-12)
