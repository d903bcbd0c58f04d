"""The filter against a plain one in numpy, its derivatives against differences, and what it says of itself against truth."""

from __future__ import annotations

import numpy as np
import pytest
from puck import DEVIATIONS, MEASURED, NOISE, NUMBERS, RAIL_NOISE, RATES, SPEED, START, puck_filter, radar, rate, speed
from textbook import TextbookBank

from doorman.estimation import Status

STEP = 0.02


def puck_runs(rng, seconds, jumps=()):
    """True states of a puck that begins as the filter believes, with the inputs that act from each on."""
    x, name, states, names, inputs = START + DEVIATIONS * rng.normal(size=5), "free", [], [], []
    for k in range(int(seconds / STEP)):
        if k in jumps:
            name = "rail" if name == "free" else "free"
        u = np.array([0.5 * np.sin(0.05 * k), 0.3 * np.cos(0.08 * k)])
        x = x + STEP * rate(name, x, u) + np.sqrt(STEP) * (NOISE if name == "free" else RAIL_NOISE) * rng.normal(size=5)
        if name == "rail":
            x[3] = 0.1 * x[2] ** 2
        states.append(x)
        names.append(name)
        inputs.append(u)
    return np.array(states), names, np.array(inputs)


def reading(rng, kind, x):
    return radar(x) + MEASURED * rng.normal(size=2) if kind == "radar" else speed(x) + SPEED * rng.normal(size=1)


def test_a_bank_with_rows_limits_and_switches_equals_the_textbooks():
    rng = np.random.default_rng(1)
    states, _, inputs = puck_runs(rng, 4.0, jumps=(60, 130))
    bank, plain = puck_filter(), TextbookBank(START, DEVIATIONS)
    bank.start(0.0, START, DEVIATIONS, inputs=inputs[0])
    nis = []
    for k, x in enumerate(states):
        time, kind = (k + 1) * STEP, "radar" if k % 3 else "speed"
        y = reading(rng, kind, x)
        plain.predict(time - bank.time, inputs[k])
        (nis if kind == "radar" else []).append(plain.measure(y, kind))
        bank.measure(kind, time, y)
        bank.step(time, inputs[min(k + 1, len(inputs) - 1)])
        mean, covariance = plain.moments()
        found = bank.estimate()
        assert found.mean == pytest.approx(mean, abs=1e-7)
        assert found.covariance == pytest.approx(covariance, abs=1e-8)
        assert found.probabilities["rail"] == pytest.approx(plain.p[1], abs=1e-6)
        sides = np.array([plain.x[0][3] * plain.x[0][4], 2 * plain.x[1][4]])
        assert found.outputs["side_force"][0] == pytest.approx(plain.p @ sides, abs=1e-6)
    assert bank.log_likelihood == pytest.approx(plain.log_likelihood, abs=1e-4)
    assert bank.score("radar").mean_nis == pytest.approx(np.mean(nis), abs=1e-5)


def test_the_bank_tells_the_rail_from_the_table():
    rng = np.random.default_rng(2)
    right, said, was = [], [], []
    bank = puck_filter()
    for _ in range(12):
        jumps = np.cumsum(rng.exponential([1 / RATES["free", "rail"], 1 / RATES["rail", "free"]] * 3) / STEP).astype(
            int
        )
        states, names, inputs = puck_runs(rng, 4.0, set(jumps.tolist()))
        bank.start(0.0, START, DEVIATIONS, inputs=inputs[0], probabilities={"free": 1.0})
        for k, x in enumerate(states):
            bank.measure("radar", (k + 1) * STEP, reading(rng, "radar", x))
            bank.step((k + 1) * STEP, inputs[min(k + 1, len(inputs) - 1)])
            rail = bank.estimate().probabilities["rail"]
            said.append(rail)
            was.append(names[k] == "rail")
            right.append((rail > 0.5) == was[-1])
    assert np.mean(right) > 0.8
    assert np.mean(said) == pytest.approx(np.mean(was), abs=0.08)


def test_errors_and_innovations_are_as_large_as_the_filter_says():
    """Mean NEES of 40 runs within its 99.9 % interval at three times of a run, and NIS over all of them."""
    rng, runs, look = np.random.default_rng(3), 40, (40, 90, 149)
    nees, nis = np.zeros((runs, len(look))), []
    bank = puck_filter()
    for run in range(runs):
        states, _, inputs = puck_runs(rng, 3.0)
        bank.start(0.0, START, DEVIATIONS, inputs=inputs[0], situation="table")
        for k, x in enumerate(states):
            bank.measure("radar", (k + 1) * STEP, reading(rng, "radar", x))
            assert bank.step((k + 1) * STEP, inputs[min(k + 1, len(inputs) - 1)]) <= Status.REFUSED
            if k in look:
                found = bank.estimate()
                error = found.mean - x
                nees[run, look.index(k)] = error @ np.linalg.solve(found.covariance, error)
        nis.append(bank.score("radar").mean_nis)
    spread = 3.3 * np.sqrt(2 * 5 / runs)
    assert np.abs(nees.mean(axis=0) - 5.0).max() < spread, nees.mean(axis=0)
    assert np.mean(nis) == pytest.approx(2.0, abs=3.3 * np.sqrt(2 * 2 / (150 * runs)))


def test_slopes_of_a_prediction_are_those_of_differences():
    """Known but for one direction, a state spreads by that column of F."""
    bank, u, h = puck_filter(), np.array([0.3, -0.2]), 0.02
    bank.parameters[1] = 0.0  # no noise
    try:
        for direction in np.eye(5):
            ahead, behind = START + 1e-6 * direction, START - 1e-6 * direction
            slope = (ahead + h * rate("free", ahead, u) - behind - h * rate("free", behind, u)) / 2e-6
            bank.start(0.0, START, np.outer(direction, direction), inputs=u, situation="table")
            bank.step(h, u)
            assert bank.estimate().covariance == pytest.approx(np.outer(slope, slope), abs=1e-7)
    finally:
        bank.parameters[1] = NUMBERS[1]


def test_slopes_of_measurements_and_outputs_are_those_of_differences():
    """A vague prior in one direction moves the mean by that row's slope, and spreads an output by its own."""
    bank, small = puck_filter(), 1e-3
    for k in range(5):
        direction = np.eye(5)[k]
        ahead, behind = START + 1e-6 * direction, START - 1e-6 * direction
        slope = (speed(ahead) - speed(behind)) / 2e-6
        bank.start(0.0, START, small**2 * np.outer(direction, direction), situation="table")
        bank.measure("speed", 1e-9, speed(START) + 1.0)
        bank.step(1e-9, np.zeros(2))
        moved = bank.estimate().mean - START
        assert moved[k] == pytest.approx(small**2 * slope[0] / SPEED**2, rel=1e-3, abs=2e-9)
        side = abs(ahead[3] * ahead[4] - behind[3] * behind[4]) / 2e-6
        bank.start(0.0, START, small**2 * np.outer(direction, direction), situation="table")
        bank.step(1e-12, np.zeros(2))
        assert bank.estimate().outputs["side_force"][1] == pytest.approx(small * side, rel=1e-3, abs=1e-8)
