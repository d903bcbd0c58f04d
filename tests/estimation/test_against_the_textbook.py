"""The filter against a plain one in numpy, and what it says of itself against truth.

The plain one is an interacting multiple model filter straight from the textbook: matrices, and derivatives by differences.
Bar-Shalom, Li and Kirubarajan: Estimation with Applications to Tracking and Navigation, 2001, sections 5.2.3, 10.3.2 and 11.6.6.
"""

from __future__ import annotations

import numpy as np
import pytest
from puck import (
    DEVIATIONS,
    FORWARD,
    MEASURED,
    NOISE,
    RAIL,
    RAIL_LASTS,
    RAIL_NOISE,
    RATES,
    SPEED,
    START,
    puck_filter,
    radar,
    rate,
    speed,
)

from doorman.estimation import Status

NAMES = ("free", "rail")


def jacobian(function, x):
    steps = 1e-6 * np.eye(x.size)
    return np.column_stack([(function(x + step) - function(x - step)) / 2e-6 for step in steps])


class TextbookBank:
    def __init__(self, mean, deviations):
        self.x = [np.array(mean) for _ in NAMES]
        self.P = [np.diag(deviations**2) for _ in NAMES]
        self.p = np.full(2, 0.5)
        self.log_likelihood = 0.0

    def predict(self, h, u):
        away = 1 - np.exp(-h * np.array([RATES["free", "rail"], RATES["rail", "free"]]))
        pi = np.array([[1 - away[0], away[0]], [away[1], 1 - away[1]]])
        c = pi.T @ self.p
        mu = pi * self.p[:, None] / c
        x = [sum(mu[i, j] * self.x[i] for i in range(len(c))) for j in range(len(c))]
        P = [
            sum(mu[i, j] * (self.P[i] + np.outer(self.x[i] - x[j], self.x[i] - x[j])) for i in range(len(c)))
            for j in range(len(c))
        ]
        logs = np.zeros(len(c))
        for j, name in enumerate(NAMES):
            F = np.eye(5) + h * jacobian(lambda z, name=name: rate(name, z, u), x[j])
            self.x[j], self.P[j] = (
                x[j] + h * rate(name, x[j], u),
                F @ P[j] @ F.T + h * np.diag((NOISE if name == "free" else RAIL_NOISE) ** 2),
            )
            if name == "rail":
                logs[j] = self._hold(j, h)
            self.x[j][4] = max(self.x[j][4], -3.0)
        self._reweigh(c, logs)

    def _hold(self, j, h):
        x, P, loss = self.x[j], self.P[j], 0.0
        if x[2] < 0:
            loss = 0.5 * min(h / RAIL_LASTS, 1) * max(x[2] ** 2 - P[2, 2], 0) / (P[2, 2] + FORWARD**2)
        R = np.array([[RAIL**2 * max(RAIL_LASTS / h, 1)]])

        def row(z):
            return z[3:4] - 0.1 * z[2] ** 2

        G, g = jacobian(row, x), row(x)[0]
        spread = (G @ P @ G.T)[0, 0]
        loss += 0.5 * min(h / RAIL_LASTS, 1) * max(g**2 - spread, 0) / (spread + RAIL**2)
        self._update(j, np.zeros(1), row, R)
        return -loss

    def _update(self, j, y, h, R):
        x, P = self.x[j], self.P[j]
        H = jacobian(h, x)
        nu, S = y - h(x), H @ P @ H.T + R
        K = P @ H.T @ np.linalg.inv(S)
        self.x[j], self.P[j] = x + K @ nu, (np.eye(5) - K @ H) @ P
        return nu @ np.linalg.solve(S, nu), S

    def measure(self, y, kind):
        R = np.diag(MEASURED**2) if kind == "radar" else np.array([[SPEED**2]])
        logs, nis = np.zeros(2), np.zeros(2)
        for j, name in enumerate(NAMES):
            scale = 1.1 if name == "rail" else 1.0
            h = radar if kind == "radar" else lambda z, scale=scale: scale * speed(z)
            nis[j], S = self._update(j, y, h, R)
            self.x[j][4] = max(self.x[j][4], -3.0)
            logs[j] = -0.5 * (nis[j] + np.log(np.linalg.det(2 * np.pi * S)))
        self.log_likelihood += np.log(self.p @ np.exp(logs))
        self._reweigh(self.p, logs)
        return self.p @ nis

    def _reweigh(self, c, logs):
        w = c * np.exp(logs - logs.max())
        self.p = w / w.sum()

    def moments(self):
        x = sum(p * z for p, z in zip(self.p, self.x, strict=True))
        return x, sum(p * (P + np.outer(z - x, z - x)) for p, z, P in zip(self.p, self.x, self.P, strict=True))


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
        (free, rail), slopes = plain.x, np.zeros((2, 5))
        sides = np.array([free[3] * free[4], 2 * rail[4]])
        slopes[0, 3:], slopes[1, 4] = (free[4], free[3]), 2.0
        spreads = [slope @ each @ slope for slope, each in zip(slopes, plain.P, strict=True)]
        side = plain.p @ sides
        deviation = np.sqrt(plain.p @ (spreads + (sides - side) ** 2))
        assert found.outputs["side_force"] == pytest.approx((side, deviation), abs=1e-6)
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
