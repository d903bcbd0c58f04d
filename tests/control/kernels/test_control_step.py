"""The position controller's kernels against their equations in plain numpy."""

import numpy as np

from doorman.control.position_controller import PositionController, Setpoint
from doorman.kinematics.vehicles.actuation import saturate
from doorman.scenario import ControlSection

MASS, GRAVITY, STRONGEST, SETTINGS = 2.9, 9.81, 70.0, ControlSection()
UP = np.array([0.0, 0.0, 1.0])


class PlainObserver:
    """Plain twin of `DisturbanceObserver`."""

    def __init__(self) -> None:
        self.rate, self.damping, self.limit = (
            SETTINGS.observer_rate,
            SETTINGS.observer_damping,
            SETTINGS.max_push,
        )
        self.gain, self.inner, self.outer, self.estimate = MASS * self.rate**2, np.zeros(3), None, np.zeros(3)

    def update(self, position, force, dt) -> None:
        if self.outer is None:
            self.outer = -self.gain * position
        self.inner = self.inner - dt * self.rate**2 * (self.estimate + force)
        self.outer = self.outer + dt * (self.inner - self.damping * self.rate * self.estimate)
        raw = self.gain * position + self.outer
        self.estimate = np.clip(raw, -self.limit, self.limit)
        self.outer = self.outer + self.estimate - raw
        self.inner = self.inner + 10.0 * self.rate / max(10.0 * self.rate * dt, 1.0) * (self.estimate - raw)

    def align(self, direction, disturbance, velocity) -> None:
        change = (direction @ (disturbance - self.estimate)) * direction
        self.estimate, self.outer = self.estimate + change, self.outer + change
        settled = self.damping * self.rate * self.estimate - self.gain * velocity
        self.inner = self.inner + (direction @ (settled - self.inner)) * direction


class PlainController:
    """Plain twin of `PositionController.update`, up to the wanted force."""

    def __init__(self) -> None:
        self.observer, self.acting, self.free, self.flown = PlainObserver(), np.zeros(3), np.zeros(3), 0.0
        self.most, self.weight = 0.024 * MASS * GRAVITY, MASS * GRAVITY * UP

    def update(self, position, velocity, to: Setpoint, dt) -> tuple[np.ndarray, np.ndarray]:
        self.observer.update(position, self.acting, dt)
        touches = bool(to.force.any())
        if touches:
            self.bound(to, velocity)
        found = self.observer.estimate
        if not touches:
            self.flown += dt
            self.free = self.free + (1.0 if self.flown < 4.0 else min(dt / 4.0, 1.0)) * (found - self.free)
        elif to.push is None:
            self.free = np.array([found[0], found[1], self.free[2]])
        if to.push is not None:
            found = self.free + np.clip(found[2] - self.free[2], -self.most, self.most) * UP
        found = found - (to.normal @ found) * to.normal
        errors = to.velocity - velocity, to.position - position
        correction = SETTINGS.velocity_gain * errors[0] + SETTINGS.position_gain * errors[1]
        wanted = MASS * (to.acceleration + correction) + self.weight + to.force - found
        if to.push is not None:
            wanted = wanted + (to.push - to.normal @ (wanted - self.weight)) * to.normal
        self.acting = saturate(wanted, STRONGEST, SETTINGS.max_tilt) - self.weight - to.force
        return saturate(wanted, STRONGEST, SETTINGS.max_tilt), found

    def bound(self, to: Setpoint, velocity) -> None:
        if to.push is not None:
            self.observer.align(np.array([-to.normal[1], to.normal[0], 0.0]), self.free, velocity)
        lift = self.observer.estimate[2] - self.free[2]
        if abs(lift) > self.most:
            self.observer.align(UP, self.free + np.copysign(self.most, lift) * UP, velocity)


def setpoint(random: np.random.Generator, kind: str) -> Setpoint:
    """Somewhere, of a vehicle that flies freely, grips or pushes."""
    normal = np.array([0.6, 0.8, 0.0]) if kind != "free" else np.zeros(3)
    force, push = (2.0 * normal, 3.0 if kind == "push" else None)
    places = (random.normal(0.0, size, 3) for size in (0.1, 0.1, 0.5))
    return Setpoint(*places, 0.3, force, normal, np.zeros(2), push)


def test_the_kernel_is_the_plain_controller() -> None:
    random, fast, plain = (
        np.random.default_rng(5),
        PositionController(MASS, GRAVITY, STRONGEST, SETTINGS),
        PlainController(),
    )
    for k in range(900):
        kind, dt = ("free", "grip", "push", "free")[k // 225], 0.0 if k == 0 else 0.01
        given = random.normal(0.0, 0.05, 3), random.normal(0.0, 0.1, 3), setpoint(random, kind), dt
        thrust, (force, disturbance) = fast.update(*given), plain.update(*given)
        np.testing.assert_allclose(thrust.force, force, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(thrust.disturbance, disturbance, rtol=1e-10, atol=1e-10)
        np.testing.assert_allclose(fast.observer.estimate, plain.observer.estimate, rtol=1e-10, atol=1e-10)
