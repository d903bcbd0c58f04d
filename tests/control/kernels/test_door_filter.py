"""The door filter's kernels against their equations in plain numpy."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from doorman.control.estimation.beliefs import Beliefs
from doorman.control.estimation.door_filter import DoorFilter
from doorman.control.kernels.door_filter.memory import (
    ANGLE,
    DAMPING,
    FRICTION,
    INERTIA,
    RATE,
    STIFFNESS,
    TORQUE,
    WIND_X,
)
from doorman.model import Model
from doorman.scenario import Scenario

DOORS = ("push", "pull", "drawer", "hatch")


class PlainFilter:
    """Plain twin of `DoorFilter.update` and `DoorFilter.hinge`."""

    def __init__(self, model: Model) -> None:
        like = DoorFilter(model, Beliefs.of(model))
        self.z, self.p = like.state.copy(), like.covariance.copy()
        self.door, self.settings, self.lever = model.door, Beliefs.of(model), model.coupling.lever_length
        self.vehicle = model.vehicle.mass * self.lever**2
        self.seen, self.touched, self.stood, self.sealed = -math.inf, False, True, -math.inf
        self.push_noise, self.deviation = self.settings.push_noise, self.settings.torque_deviation

    def known(self) -> float:
        return self.door.closing_torque + self.door.weight_torque(self.z[ANGLE])

    def wind_lever(self) -> np.ndarray:
        return self.door.wind_lever * self.door.normal(self.z[ANGLE])[:2]

    def holds(self) -> bool:
        closer = abs(self.z[STIFFNESS] * (self.z[ANGLE] - self.door.rest_angle)) + abs(self.known())
        return bool(self.z[FRICTION] > closer)

    def update(self, push, touching, tip_angle, measured_at, now, time_step, wind) -> None:
        if touching and not self.touched:
            self.touched = True
            self.expect(wind[:2])
        if touching and abs(self.z[RATE]) < 0.02:
            self.track(tip_angle, now - measured_at, time_step)
            return
        if not touching and self.z[RATE] == 0.0 and self.holds():
            return
        self.come_loose(push if touching else 0.0)
        self.predict(push if touching else 0.0, touching, time_step)
        if touching and measured_at > self.seen:
            self.correct(tip_angle, now - measured_at)
        self.seen = measured_at

    def expect(self, wind) -> None:
        strength, s = float(np.linalg.norm(wind)), self.settings
        self.push_noise += s.push_noise_in_wind * strength
        self.deviation += s.torque_deviation_in_wind * strength
        self.p[TORQUE, TORQUE] = self.deviation**2
        if strength > 0.0:
            along = min(strength / 0.1, 1.0) / strength * wind
            self.z[WIND_X:] = (s.leaf_wind[0] + s.leaf_wind_share * (strength - s.leaf_wind[0])) * along
            self.p[WIND_X:, WIND_X:] += s.leaf_wind[1] ** 2 * np.outer(along, along)

    def come_loose(self, push) -> None:
        if self.stood:
            self.stood, deviation = False, math.sqrt(self.p[FRICTION, FRICTION])
            bears = self.lever * push + self.known() + self.z[STIFFNESS] * (self.z[ANGLE] - self.door.rest_angle)
            if abs(bears) > self.z[FRICTION] + 2.0 * deviation + self.deviation:
                self.sealed, self.p[TORQUE, TORQUE] = self.z[ANGLE], bears**2
        elif math.isfinite(self.sealed) and abs(self.z[ANGLE] - self.sealed) > 0.05:
            self.sealed, self.z[TORQUE] = -math.inf, 0.0
            self.p[TORQUE, :] = self.p[:, TORQUE] = 0.0
            self.p[TORQUE, TORQUE] = self.deviation**2

    def track(self, tip_angle, age, time_step) -> None:
        self.stood = True
        parts = math.ceil(time_step / 0.02)
        for _ in range(parts):
            off = tip_angle - self.z[ANGLE]
            self.z[ANGLE] += time_step / parts * (self.z[RATE] + 16.0 * off)
            self.z[RATE] += time_step / parts * 64.0 * off
        rate = np.array([16.0 * abs(off), 0.0, 0.01])
        angle = np.array([abs(off), 0.002, 0.0]) + age * rate
        self.p[:2, :] = self.p[:, :2] = 0.0
        self.p[:2, :2] = [[angle @ angle, angle @ rate], [angle @ rate, rate @ rate]]

    def predict(self, push, touching, dt) -> None:
        z = self.z
        inertia, slip, wind = z[INERTIA] + self.vehicle * touching, math.tanh(z[RATE] / 0.01), self.wind_lever()
        off = z[ANGLE] - self.door.rest_angle
        torque = z[DAMPING] * z[RATE] + z[FRICTION] * slip + z[STIFFNESS] * off + z[TORQUE] + self.known()
        acceleration = -(self.lever * push + torque + wind @ z[WIND_X:]) / inertia
        stiff = z[FRICTION] * (1.0 - slip * slip) / 0.01
        fade, change = math.exp(-dt / self.settings.torque_time), np.eye(9)
        change[ANGLE, RATE] = dt
        change[RATE] = -dt / inertia * np.array([z[STIFFNESS], 0, 1, z[RATE], slip, off, acceleration, *wind])
        change[RATE, RATE] = 1.0 - dt * min((z[DAMPING] + stiff) / inertia, 0.5 / dt)
        change[TORQUE, TORQUE] = fade
        rate = z[RATE] + dt * acceleration
        z[ANGLE] += dt * z[RATE]
        if not touching and self.holds() and (rate * z[RATE] <= 0.0 or abs(rate) < 0.01):
            rate = 0.0
        z[RATE] = rate
        if self.known() != 0.0 and self.door.opening_of(z[ANGLE]) < 0.0:
            z[ANGLE], z[RATE] = self.door.angle_of_opening(0.0), 0.0
        z[TORQUE] *= fade
        self.p = change @ self.p @ change.T
        self.p[RATE, RATE] += dt * (self.push_noise * self.lever / inertia) ** 2
        self.p[TORQUE, TORQUE] += (1.0 - fade**2) * self.deviation**2

    def correct(self, tip_angle, age) -> None:
        row, noise, share = np.zeros(9), self.settings.angle_noise**2, (0.4, 2.5)
        row[ANGLE], row[RATE] = 1.0, -age
        gain = self.p @ row / (row @ self.p @ row + noise)
        if math.isfinite(self.sealed):
            gain[TORQUE + 1 :] = 0.0
        self.z += gain * (tip_angle - row @ self.z)
        self.z[DAMPING:INERTIA] = np.maximum(self.z[DAMPING:INERTIA], 0.0)
        self.z[INERTIA] = np.clip(self.z[INERTIA], share[0] * self.door.inertia, share[1] * self.door.inertia)
        left = np.eye(9) - np.outer(gain, row)
        self.p = left @ self.p @ left.T + noise * np.outer(gain, gain)
        self.p = 0.5 * (self.p + self.p.T)

    def hinge(self) -> list[float]:
        z, p, turned = self.z, self.p, abs(self.door.rest_angle - self.z[ANGLE])
        squares, together = p[FRICTION, FRICTION] + turned**2 * p[STIFFNESS, STIFFNESS], p[FRICTION, STIFFNESS]
        sums = [math.sqrt(max(squares + sign * 2.0 * turned * together, 0.0)) for sign in (1.0, -1.0)]
        wind = (-1.0 if self.door.side == "push" else 1.0) * float(self.wind_lever() @ z[WIND_X:])
        spare = z[FRICTION] - abs(self.known()) - z[STIFFNESS] * turned
        rows = range(DAMPING, INERTIA + 1)
        return [*z[DAMPING : INERTIA + 1], *(math.sqrt(p[k, k]) for k in rows), sums[0], wind, spare, sums[1]]


def flights(model: Model, seed: int):
    """Both filters, and what they take in: a touch, a swing, a loss, poses that are late, periods that are long."""
    random, sense = np.random.default_rng(seed), model.travel.sense
    wind, start = random.normal(0.0, 1.0, 3) * (seed % 2), model.start_angle
    fast, plain, now = DoorFilter(model, Beliefs.of(model)), PlainFilter(model), 0.0
    for k in range(400):
        time_step = 0.05 if k % 61 == 60 else 0.004
        now += time_step
        touching = k > 20 and k % 150 < 120
        angle = start + sense * max(0.0, 0.1 * (now - 0.3)) + random.normal(0.0, 1e-3)
        push = random.normal(-40.0 * sense if k < 120 else -3.0 * sense, 1.0)
        given = push, touching, angle, now - 0.008 * (k % 3), now, time_step
        fast.update(*given, wind=wind)
        plain.update(*given, wind)
        yield SimpleNamespace(fast=fast, plain=plain, touching=touching)


@pytest.mark.parametrize("seed", [0, 1])
@pytest.mark.parametrize("name", DOORS)
def test_the_kernel_is_the_plain_filter(name: str, seed: int) -> None:
    model, moved, stood, sealed = Model(Scenario.load(f"shipped:{name}")), 0, 0, 0
    for both in flights(model, seed):
        np.testing.assert_allclose(both.fast.state, both.plain.z, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(both.fast.covariance, both.plain.p, rtol=1e-12, atol=1e-12)
        moved += both.touching and abs(both.fast.rate) >= 0.02
        stood += both.touching and abs(both.fast.rate) < 0.02
        sealed += math.isfinite(both.plain.sealed)
        both.fast.state[:], both.fast.covariance[:] = both.plain.z, both.plain.p  # one step at a time
    assert moved > 50 and stood > 5 and sealed > 5


@pytest.mark.parametrize("name", DOORS)
def test_the_hinge_is_the_plain_one(name: str) -> None:
    model = Model(Scenario.load(f"shipped:{name}"))
    for both in list(flights(model, 1))[::50]:
        hinge = both.fast.hinge()
        found = [getattr(hinge, field) for field in hinge.__dataclass_fields__]
        both.plain.z, both.plain.p = both.fast.state, both.fast.covariance
        np.testing.assert_allclose(found, both.plain.hinge(), rtol=1e-12, atol=1e-12)
