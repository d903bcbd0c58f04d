"""The vehicle observer's kernel against its equations in plain numpy."""

import math

import numpy as np
import pytest

from doorman.control.observers.vehicle_observer import VehicleObserver

MASS, RATE = 2.7, 15.0


class PlainObserver:
    """Plain twin of `VehicleObserver.update`."""

    def __init__(self) -> None:
        self.position, self.velocity, self.outer_force = np.zeros(3), np.zeros(3), np.zeros(3)
        self.center, self.seen, self.late = (np.zeros(3), np.zeros(3)), None, 0.0

    def update(self, position, measured_at, now, force, time_step, center) -> None:
        if self.seen is None:
            self.position, self.velocity = position.copy(), self.velocity - center[1]
            self.center, self.seen = center, measured_at
            return
        place, speed = self.position + self.center[0], self.velocity + self.center[1]
        acceleration = (force + self.outer_force) / MASS
        place = place + time_step * (speed + 0.5 * time_step * acceleration)
        speed = speed + time_step * acceleration
        if measured_at > self.seen:
            apart, age = measured_at - self.seen, now - measured_at
            off = position + center[0] - (place - age * speed)
            self.late = max(age, self.late - 0.2 * apart)
            kept = math.exp(-min(RATE, 0.6 / self.late if self.late > 0.0 else RATE) * apart)
            place = place + (1.0 - kept**3) * off
            speed = speed + 1.5 * (1.0 - kept**2) * (1.0 - kept) / apart * off
            self.outer_force = self.outer_force + MASS * (1.0 - kept) ** 3 / apart**2 * off
            self.seen = measured_at
        self.center, self.position, self.velocity = center, place - center[0], speed - center[1]


@pytest.mark.parametrize("delay", [0.0, 0.02, 0.2])
def test_the_kernel_is_the_plain_observer(delay: float) -> None:
    random, fast, plain, now = np.random.default_rng(3), VehicleObserver(MASS, RATE), PlainObserver(), 0.0
    for k in range(300):
        time_step = 0.0 if k == 0 else float(random.choice([0.004, 0.01]))
        now += time_step
        seen = now - delay * (k % 3) - 0.004 * (k % 2)
        center = random.normal(0.0, 0.02, 3), random.normal(0.0, 0.1, 3)
        given = random.normal(0.0, 1.0, 3), seen, now, random.normal(0.0, 3.0, 3), time_step, center
        fast.update(*given)
        plain.update(*given)
        for name in ("position", "velocity", "outer_force"):
            np.testing.assert_allclose(getattr(fast, name), getattr(plain, name), rtol=1e-10, atol=1e-12)
