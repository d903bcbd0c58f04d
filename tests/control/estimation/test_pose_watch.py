"""Age and noise of the poses are measured in flight, and judged by what contact bears."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.control.estimation.pose_age import oldest_pose
from doorman.control.estimation.pose_watch import PoseWatch
from doorman.model import Model
from doorman.signals import Measurement

TICK = 0.004
PUSH, GRIP = Model("push"), Model("paper")


def watched(model: Model, seconds: float, noise: float, latency: float, rate: float, gap: float = 0.0) -> PoseWatch:
    """A hover whose cameras have this noise [m], latency [s], rate [1/s] and one gap [s]."""
    random, watch, n = np.random.default_rng(3), PoseWatch(model), model.n_arm
    taken = [k / rate for k in range(round(seconds * rate)) if not 0.5 < k / rate < 0.5 + gap]
    places = [1e-2 * math.sin(t) + noise * random.standard_normal(3) for t in taken]
    for tick in range(round(seconds / TICK)):
        now = tick * TICK
        came = [k for k, t in enumerate(taken) if t + latency <= now]
        if came:
            k = came[-1]
            measured = Measurement(
                now, places[k], np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(n), np.zeros(n), taken[k]
            )
            watch.note(measured)
    return watch


def test_poses_are_not_judged_before_there_are_enough() -> None:
    watch = watched(PUSH, 0.3, 0.01, 0.1, 100.0)
    assert not watch.judged and watch.unfit() == ""


@pytest.mark.parametrize(("latency", "rate", "fit"), [(0.02, 125.0, True), (0.04, 100.0, True), (0.06, 50.0, False)])
def test_poses_that_are_older_than_contact_bears_are_told(latency: float, rate: float, fit: bool) -> None:
    for model in (PUSH, GRIP):
        assert (latency + 1.0 / rate < oldest_pose(model.scenario.control)) == fit
        watch = watched(model, 2.0, 0.0001, latency, rate)
        assert watch.judged
        assert (watch.unfit() == "") == fit
        assert fit or watch.unfit().startswith("the poses are too old for contact: ")


@pytest.mark.parametrize(("noise", "fit"), [(0.001, True), (0.002, True), (0.005, False)])
def test_noise_that_moves_the_tips_force_too_much_is_told_of_a_push(noise: float, fit: bool) -> None:
    watch = watched(PUSH, 2.0, noise, 0.03, 100.0)
    assert (watch.unfit() == "") == fit
    assert fit or "too noisy for contact: 4.9 mm" in watch.unfit()
    assert watched(GRIP, 2.0, noise, 0.03, 100.0).unfit() == ""


def test_a_single_gap_does_not_count() -> None:
    assert watched(PUSH, 2.0, 0.001, 0.02, 100.0, gap=0.2).unfit() == ""


def test_a_missing_pose_of_a_vehicle_that_flies_is_no_noise() -> None:
    """At 2 m/s and 100 Hz, three poses with one missing among them bend by 2 cm: here two of three do."""
    watch, n = PoseWatch(PUSH), PUSH.n_arm
    for k in (k for k in range(400) if k % 4 != 0):
        taken = k / 100.0
        place = np.array([2.0 * taken, 0.0, 1.0])
        watch.note(
            Measurement(taken + 0.02, place, np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(n), np.zeros(n), taken)
        )
    assert watch.judged
    assert watch.unfit() == ""
