"""The pose of a door from touches of its frame, against doors that stand elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.control.estimation.frame_fit import FrameFit, FrameTouch, fit_frame
from doorman.kinematics.doors.frame_places import FramePlace

HINGE = np.array([0.3, -0.2, 0.4])
INTO, ALONG = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
PLACES = [
    FramePlace(HINGE + np.array([-0.1, 1.6, 0.8]), INTO),
    FramePlace(HINGE + np.array([-0.1, -0.5, 0.8]), INTO),
    FramePlace(HINGE + np.array([-0.07, 0.0, 0.8]), -ALONG),
]
PLACE, YAW, NOISE = 0.015, 0.026, 0.003


def touched(
    offset: tuple[float, float], yaw: float, slip: float = 0.0, places: list[FramePlace] = PLACES
) -> list[FrameTouch]:
    """Touches of a door that stands elsewhere; the tip slips along each face."""
    turn = np.array([[math.cos(yaw), -math.sin(yaw), 0.0], [math.sin(yaw), math.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    found = []
    for place in places:
        beside = np.array([-place.normal[1], place.normal[0], 0.0])
        at = HINGE + turn @ (place.point - HINGE + slip * beside) + np.array([*offset, 0.0])
        found.append(FrameTouch(place, at))
    return found


def fitted(touches: list[FrameTouch], place: float = PLACE, yaw: float = YAW, noise: float = NOISE) -> FrameFit:
    return fit_frame(HINGE, touches, place, yaw, noise)


@pytest.mark.parametrize("offset, yaw", [((0.02, -0.03), 0.05), ((-0.01, 0.02), -0.04), ((0.0, 0.0), 0.0)])
def test_three_touches_find_the_door(offset: tuple[float, float], yaw: float) -> None:
    fit = fitted(touched(offset, yaw, slip=0.02), place=1.0, yaw=1.0, noise=1e-4)
    np.testing.assert_allclose(fit.offset, offset, atol=2e-5)
    assert fit.yaw == pytest.approx(yaw, abs=1e-5)


def test_a_placed_face_is_where_it_was_touched() -> None:
    touches = touched((0.02, -0.03), 0.05)
    fit = fitted(touches, place=1.0, yaw=1.0, noise=1e-5)
    for touch in touches:
        placed = fit.placed(touch.place)
        np.testing.assert_allclose(placed.point, touch.tip, atol=1e-5)
        assert placed.normal @ INTO == pytest.approx(touch.place.normal @ INTO * math.cos(0.05), abs=0.051)


def test_two_touches_of_the_front_say_nothing_of_the_place_along_it() -> None:
    fit = fitted(touched((0.02, 0.0), 0.02, places=PLACES[:2]))
    assert fit.offset[0] == pytest.approx(0.02, abs=0.003) and fit.yaw == pytest.approx(0.02, abs=0.002)
    deviations = np.sqrt(np.diag(fit.covariance))
    assert deviations[1] == pytest.approx(PLACE, rel=0.01) and deviations[2] < 0.1 * YAW


def test_without_a_touch_the_map_is_all_that_is_known() -> None:
    fit = fitted([])
    assert not fit.offset.any() and fit.yaw == 0.0
    np.testing.assert_allclose(np.diag(fit.covariance), np.array([PLACE, PLACE, YAW]) ** 2)
    assert fit.deviation(PLACES[0]) == pytest.approx(math.hypot(PLACE, 1.6 * YAW), rel=1e-6)


def test_the_covariance_is_that_of_many_noisy_touches(rng: np.random.Generator) -> None:
    off = []
    for _ in range(400):
        offset, yaw = rng.normal(0.0, PLACE, 2), float(rng.normal(0.0, YAW))
        touches = touched((float(offset[0]), float(offset[1])), yaw)
        noisy = [FrameTouch(each.place, each.tip + rng.normal(0.0, NOISE, 3)) for each in touches]
        fit = fitted(noisy)
        off.append([*(fit.offset - offset), fit.yaw - yaw])
    covariance = fitted(touched((0.0, 0.0), 0.0)).covariance
    np.testing.assert_allclose(np.std(off, axis=0), np.sqrt(np.diag(covariance)), rtol=0.15)
    assert np.corrcoef(np.transpose(off))[0, 2] == pytest.approx(
        covariance[0, 2] / math.sqrt(covariance[0, 0] * covariance[2, 2]), abs=0.15
    )


WALK = 0.002
"""So much that it outweighs the noise of touches [m/s^½]."""


def test_the_stated_covariance_covers_a_frame_that_walks(rng: np.random.Generator) -> None:
    """At the last touch it is no less than that of many flights, and later it comes near it."""
    times, later, off, then = [0.0, 10.0, 25.0], 60.0, [], []
    for _ in range(600):
        offset, yaw = rng.normal(0.0, PLACE, 2), float(rng.normal(0.0, YAW))
        steps = np.sqrt(np.diff([*times, later]))[:, None] * WALK * rng.normal(size=(3, 2))
        walked = np.cumsum([np.zeros(2), *steps], axis=0)
        noisy = [
            FrameTouch(one.place, one.tip + rng.normal(0.0, NOISE, 3) + np.array([*by, 0.0]), at)
            for one, by, at in zip(touched((float(offset[0]), float(offset[1])), yaw), walked, times, strict=False)
        ]
        fit = fit_frame(HINGE, noisy, PLACE, YAW, NOISE)
        off.append([*(fit.offset - offset - walked[2]), fit.yaw - yaw])
        then.append(fit.offset - offset - walked[3])
    assert np.std(off, axis=0)[0] > 1.5 * math.sqrt(fit.covariance[0, 0])
    assert (np.std(off, axis=0)[:2] < 1.05 * np.sqrt(np.diag(fit.covariance_at(times[-1], WALK)))[:2]).all()
    share = np.std(then, axis=0) / np.sqrt(np.diag(fit.covariance_at(later, WALK)))[:2]
    assert 0.7 < share.min() and share.max() < 1.05
