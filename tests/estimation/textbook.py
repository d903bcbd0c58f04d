"""An interacting multiple model filter in plain numpy, straight from the textbook: matrices, and derivatives by differences.

Bar-Shalom, Li and Kirubarajan: Estimation with Applications to Tracking and Navigation, 2001, sections 5.2.3, 10.3.2 and 11.6.6.
"""

from __future__ import annotations

import numpy as np
from puck import FORWARD, MEASURED, NOISE, RAIL, RAIL_LASTS, RAIL_NOISE, RATES, SPEED, radar, rate, speed

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
