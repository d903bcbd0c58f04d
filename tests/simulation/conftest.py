"""Simulators of the shipped task, with overrides; models are built once for each set of overrides."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from doorman.model import Model
from doorman.scenario import Scenario
from doorman.simulation import AttitudeGains, Disturbance, Simulator

HOVER = 3.0 * 9.81


@functools.lru_cache(maxsize=64)
def _model(items: tuple[tuple[str, Any], ...]) -> Model:
    return Model(Scenario.load(Path(__file__).with_name("default.toml"), dict(items)))


def make_model(**overrides: Any) -> Model:
    """Model of the shipped task, with no friction unless one is given; `a__b=1` overrides the key `a.b`."""
    if not {"door__friction", "simulation__door_friction"} & overrides.keys():
        overrides["simulation__door_friction"] = 0.0
    return _model(tuple(sorted((key.replace("__", "."), value) for key, value in overrides.items())))


class Flight:
    """A simulator with short ways to fly it."""

    def __init__(
        self,
        disturbance: Callable[[float], Disturbance] | None = None,
        gains: AttitudeGains | None = None,
        away: bool = False,
        time_step: float = 1e-3,
        **overrides: Any,
    ) -> None:
        self.model = make_model(**overrides)
        self.simulator = Simulator(self.model, time_step, disturbance, gains)
        self.plant = self.simulator.plant
        self.data = self.plant.data
        if away:
            self.data.qpos[0] -= 3.0

    def command(self, thrust: float = HOVER, attitude: Any = (0, 0, 0), arm_rates: Any = None) -> None:
        rates = np.zeros(self.model.n_arm) if arm_rates is None else np.asarray(arm_rates, dtype=float)
        self.simulator.set_command(thrust, attitude, rates)

    def lean(self, force: float) -> None:
        """Ask for the tilt and thrust that push along +x with this force and carry the weight."""
        self.command(math.hypot(HOVER, force), (0.0, math.atan2(force, HOVER), 0.0))

    def run(self, duration: float, every: int = 1) -> list[Any]:
        """Truth after every few physics steps."""
        truths = []
        for _ in range(round(duration / self.simulator.time_step / every)):
            self.simulator.advance(every)
            truths.append(self.simulator.truth())
        return truths

    def gap(self) -> float:
        """Distance between the tip and the contact point [m]."""
        return float(np.linalg.norm(self.data.site("tip").xpos - self.data.site("contact").xpos))


@pytest.fixture
def flight() -> type[Flight]:
    """The class `Flight`: call it with overrides."""
    return Flight


@pytest.fixture
def model() -> Callable[..., Model]:
    """The function `make_model`: call it with overrides."""
    return make_model
