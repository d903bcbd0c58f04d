"""Fly something else than the simulator: here the simulator with a link that delays every command."""

import math
from collections import deque

from doorman import Model, Scenario
from doorman.hardware.interface import Backend, Command, Measurement
from doorman.mission import Mission
from doorman.simulation import SimulatedBackend


class LateCommands(Backend):
    """A vehicle that obeys every command some ticks after it was sent."""

    def __init__(self, model: Model, ticks: int) -> None:
        self._vehicle = SimulatedBackend(model)
        self._ticks = ticks
        self._waiting: deque[Command] = deque()

    def open(self) -> None:
        """Begin."""
        self._waiting.clear()
        self._vehicle.open()

    def read(self) -> Measurement:
        """What the sensors say."""
        return self._vehicle.read()

    def command(self, command: Command) -> None:
        """Send a command, later."""
        self._waiting.append(command)
        if len(self._waiting) > self._ticks:
            self._vehicle.command(self._waiting.popleft())

    def stop(self) -> None:
        """Let go of everything."""
        self._vehicle.stop()


model = Model(Scenario.load("paper", overrides={"mission.start": "contact"}))
for ticks in (0, 3):
    mission = Mission(model)
    mission.fly(LateCommands(model, ticks), duration=1.0)
    angle = mission.recorder.recording()["estimate"]["state"][-1, 3]
    print(f"{ticks} ticks late: the door is at {math.degrees(angle):.1f}° after 1 s")
