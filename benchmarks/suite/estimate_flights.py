"""The flights whose recordings judge estimates: groups of seeded draws, each about what one world does to an estimate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import doorman
from doorman.recording import Recording
from doorman.scenario import Scenario

WIND, DOOR, SENSORS, HAND = "simulation.gust.", "simulation.door_", "simulation.sensors.", "simulation.hand."
PUSH, GRIP = "push_campaign", "paper"

_FACE = 1e-3
"""Deviation of where the leaf's face stands, as the filter is told it [m]."""

_STILL = {WIND + "vehicle": 0.0, WIND + "leaf": 0.0}


@dataclass(frozen=True)
class Flight:
    """One recording."""

    group: str
    number: int
    scenario: str
    overrides: dict[str, Any]

    @property
    def name(self) -> str:
        """Of its file."""
        return f"{self.group}_{self.number}"

    def recording(self, folder: Path) -> Recording:
        """What is there, or flown now."""
        file = folder / f"{self.name}.mcap"
        if not file.exists():
            scenario = Scenario.load(self.scenario).replace(**self.overrides)
            part = file.with_suffix(".part.mcap")
            doorman.simulate(scenario, seed=1000 + self.number, path=part, force=True)
            part.rename(file)
        return Recording.load(file)


def flights(per_group: int) -> list[Flight]:
    """The same for everybody: each group draws with a seed of its own."""
    return [
        Flight(group, number, scenario, _drawn(group, number, scenario, own))
        for group, (scenario, own) in GROUPS.items()
        for number in range(per_group)
    ]


def _drawn(group: str, number: int, scenario: str, own: dict[str, Any]) -> dict[str, Any]:
    """A door whose face is not quite in its place, and a wind, by chance, then what the group is about."""
    rng = np.random.default_rng([69, number, *group.encode()])
    wind = rng.uniform(0.3, 1.5)
    draw = {
        WIND + "vehicle": wind, WIND + "leaf": wind, WIND + "direction": rng.uniform(-math.pi, math.pi),
        DOOR + "mass": rng.uniform(6.0, 20.0), DOOR + "friction": rng.uniform(0.3, 2.0),
        DOOR + "stiffness": rng.uniform(0.0, 1.5), DOOR + "damping": rng.uniform(0.0, 2.0),
    }  # fmt: skip
    if scenario == PUSH:
        draw[DOOR + "width"] = rng.uniform(1.1, 1.4)
    draw[DOOR + "face_offset"] = rng.normal(0.0, _FACE)
    return {**{key: float(value) for key, value in draw.items()}, **own}


GROUPS: dict[str, tuple[str, dict[str, Any]]] = {
    "calm": (PUSH, _STILL),
    "steady": (PUSH, {}),
    "turns": (PUSH, {WIND + "turn_rate": math.radians(15.0)}),
    "jumps": (PUSH, {WIND + "jump_rate": 0.1}),
    "late": (PUSH, {SENSORS + "latency": 0.04, SENSORS + "rate": 100.0}),
    "noisy": (PUSH, {"simulation.noise.position": 0.002, "simulation.noise.attitude": 0.006}),
    "slippery": (PUSH, {"simulation.tip_friction": 0.3, **_STILL}),
    "sagging": (PUSH, {"simulation.thrust_fall": 0.003, **_STILL}),
    "sealed": (PUSH, {DOOR + "seal": 4.0, **_STILL}),
    "ajar": (PUSH, {DOOR + "ajar": 0.1}),
    "held": (PUSH, {HAND + "door_angle": 0.8, HAND + "duration": 2.0, HAND + "hold": 8.0, **_STILL}),
    "shoved": (PUSH, {HAND + "door_angle": 0.8, HAND + "duration": 1.0, HAND + "shove": 2.0, **_STILL}),
    "blocked": (PUSH, {DOOR + "latch": 60.0, **_STILL}),
    "sensed": (PUSH, {SENSORS + "tip_force": True}),
    "grip": (GRIP, {}),
    "grip_closer": (GRIP, {DOOR + "preload": 1.0, DOOR + "stiffness": 1.0, **_STILL}),
}  # fmt: skip
"""Name, then the scenario and what is set on top of a random door and wind."""
