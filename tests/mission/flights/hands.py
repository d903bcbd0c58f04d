"""Flights of the simulator with a hand on the leaf, and one on the vehicle."""

from __future__ import annotations

import math
from collections.abc import Callable

from doorman import Model, Recording, Scenario
from doorman.mission import Mission, Phase
from doorman.recording import Recorder
from doorman.simulation import SimulatedBackend
from doorman.simulation.simulator import Disturbance
from doorman.summary import summarize

Torque = Callable[[float, float, float], float]
"""Torque of a hand in the hinge from time, door angle and door rate."""
Pull = Callable[[float], float]
"""Force on the vehicle along x from time."""


class HandledBackend(SimulatedBackend):
    """Simulator with a hand on the leaf, and one on the vehicle."""

    def __init__(self, model: Model, recorder: Recorder, torque: Torque, pull: Pull) -> None:
        self._torque, self._pull = torque, pull
        super().__init__(model, recorder=recorder, disturbance=self._hand)

    def _hand(self, time: float) -> Disturbance:
        simulator = self._simulator
        if simulator is None:
            return Disturbance()
        data, plant = simulator.plant.data, simulator.plant
        angle, rate = float(data.qpos[plant.hinge_position]), float(data.qvel[plant.hinge_velocity])
        return Disturbance(force=(self._pull(time), 0.0, 0.0), hinge_torque=self._torque(time, angle, rate))


def flown(
    torque: Torque = lambda time, angle, rate: 0.0,
    scenario: str = "push",
    on_progress: Callable[[Mission, float, float], None] | None = None,
    pull: Pull = lambda time: 0.0,
    comes_back: bool = False,
    **overrides: float | str,
) -> tuple[Recording, Mission]:
    changes = {key.replace("__", "."): value for key, value in overrides.items()}
    model, recorder = Model(Scenario.load(scenario, changes)), Recorder(None, {})
    mission = Mission(model, recorder=recorder)
    report = None if on_progress is None else lambda time, angle: on_progress(mission, time, angle)
    backend = HandledBackend(model, recorder, torque, pull)
    backend.comes_back = comes_back
    mission.fly(backend, on_progress=report)
    recording = recorder.recording()
    recording.summary = summarize(recording, model)
    return recording, mission


def hand(below: float, seconds: float, torque: Callable[[float, float], float]) -> Torque:
    """A hand that takes the leaf where it first is below an angle [deg], for a while; its torque from the way since, and rate."""
    begun: list[tuple[float, float]] = []

    def acting(time: float, angle: float, rate: float) -> float:
        if not begun and angle < math.radians(below):
            begun.append((time, angle))
        if not begun or time > begun[0][0] + seconds:
            return 0.0
        return torque(angle - begun[0][1], rate)

    return acting


class Slam:
    """Somebody throws the door shut, at 1 rad/s, so long after a phase has first begun [s]."""

    def __init__(self, phase: Phase, later: float = 0.0) -> None:
        self._phase, self._later = phase, later
        self.begins: float | None = None
        """When [s]."""
        self.thrown: float | None = None
        """When the leaf was as fast [s]."""

    def watch(self, mission: Mission, time: float, angle: float) -> None:
        """Of the mission's progress."""
        if mission.phase is self._phase and self.begins is None:
            self.begins = time + self._later

    def __call__(self, time: float, angle: float, rate: float) -> float:
        if self.begins is None or time < self.begins or self.thrown is not None:
            return 0.0
        if rate > 1.0:
            self.thrown = time
            return 0.0
        return 150.0


def aborted_in(phase: Phase) -> Callable[[Mission, float, float], None]:
    """An operator who ends the mission in a phase."""

    def watch(mission: Mission, time: float, angle: float) -> None:
        if mission.phase is phase:
            mission.abort("the operator said so")

    return watch


def phases(recording: Recording) -> list[str]:
    return recording["mission"]["state"].tolist()


def touched(recording: Recording) -> set[str]:
    """What touched what, but the tip the leaf."""
    return {pair for pairs in recording["truth"]["collision_pairs"] if pairs for pair in pairs.split(", ")}
