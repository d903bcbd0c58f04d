"""The rig in a process of its own, as users run it: its threads would share Python's lock with the flight's."""

from __future__ import annotations

import multiprocessing
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from operator import attrgetter
from typing import Any, cast

from doorman.hardware.scheduling import real_time
from doorman.model import Model
from doorman.recording import Recorder
from doorman.recording.files.messages import Value
from doorman.rig import Rig, RigSetup
from doorman.rig.emulated import SPRING
from doorman.rig.emulators.mocap.faults import StreamFaults
from doorman.scenario import Scenario

_START = 300.0
_ANSWER = 20.0
_OF_FAULTS = "model number", "present temperature", "homing offset"
"""Registers of servos that faults change and nothing else puts right."""


@dataclass
class Served:
    """What the other process can reach."""

    rig: Rig
    collisions: list[str]
    """What touched what, at every tick with a collision, over all flights."""

    def __post_init__(self) -> None:
        servos = range(1, self.rig.plant.model.n_arm + 1 + self.rig.gripper)  # the last one is the gripper's
        self.registers = {
            servo: {name: self.rig.servos.servo(servo).memory.get(name) for name in _OF_FAULTS} for servo in servos
        }

    def calm(self) -> None:
        """End every fault."""
        rig = self.rig
        rig.mocap.stream.faults = StreamFaults()
        for faults in (rig.autopilot.outgoing, rig.autopilot.incoming, rig.servos.faults):
            vars(faults).update(vars(type(faults)()))
        rig.autopilot.telemetry.heartbeats_stopped = False
        rig.autopilot.estimator.failed = False
        rig.autopilot.telemetry.confused = False
        rig.autopilot.brain.refusal = None
        rig.autopilot.brain.sticks = (0.0, 0.0, 0.0)
        rig.autopilot.battery.remaining = 0.9
        rig.plant.blow((0.0, 0.0, 0.0))
        rig.plant.block(0.0)
        rig.plant.draw_shut(0.0)
        rig.autopilot.battery.silent = False
        if rig.gripper:
            self.set_spring(SPRING)
        for servo, registers in self.registers.items():
            for name, value in registers.items():
                self.set_register(servo, name, value)
        rig.servos.plug_in()

    def set_spring(self, current: float) -> None:
        """Of the gripper [A]."""
        self.rig.servos.servo(max(self.registers)).setup.spring = current

    def restart_servo(self, servo: int) -> None:
        """Its power fails for a moment."""
        with self.rig.servos.lock:
            self.rig.servos.servo(servo).reboot(time.monotonic())

    def set_register(self, servo: int, name: str, value: int) -> None:
        with self.rig.servos.lock:
            self.rig.servos.servo(servo).memory.set(name, value)


def serve(connection: Connection, scenario: dict[str, Any], setup: RigSetup) -> None:
    """Run a rig, and do to it what is asked for, until the other end closes."""
    collisions: list[str] = []

    def note(topic: str, time: float, fields: Mapping[str, Value]) -> None:
        if topic == "truth" and (pairs := str(fields["collision_pairs"])):
            collisions.append(pairs)

    # a recorder that kept all the flights would hold the emulators up, as it grows
    recorder = Recorder(None, {}, note, keep=False)
    rig = Rig(Model(Scenario.model_validate(scenario)), setup, recorder)
    served = Served(rig, collisions)
    with real_time(), rig:
        connection.send((True, rig.arguments))
        while True:
            try:
                what, path, given = connection.recv()
            except EOFError:
                return
            try:
                connection.send((True, _do(served, what, path, given)))
            except Exception as error:
                connection.send((False, error))


def _do(served: Served, what: str, path: str, given: Any) -> Any:
    if what == "call":
        return attrgetter(path)(served)(*given)
    if what == "set":
        owner, _, name = path.rpartition(".")
        return setattr(attrgetter(owner)(served), name, given)
    return attrgetter(path)(served)


class FarRig:
    """Access to a rig that runs in a process of its own.

    Args:
        scenario: Of its plant.
        setup: Its ports.
    """

    def __init__(self, scenario: Scenario, setup: RigSetup) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, other = context.Pipe()
        arguments = (other, scenario.model_dump(mode="json"), setup)
        self._process = context.Process(target=serve, args=arguments, name="rig", daemon=True)
        self._lock = threading.Lock()
        self._process.start()
        other.close()
        self.arguments = cast("tuple[str, ...]", self._answer(_START))
        """Options of `doorman fly`."""

    def get(self, path: str) -> Any:
        """Value of an attribute, as `rig.plant.snapshot`."""
        return self._ask("get", path)

    def set(self, path: str, value: Any) -> None:
        self._ask("set", path, value)

    def call(self, path: str, *arguments: Any) -> Any:
        return self._ask("call", path, arguments)

    def stop(self) -> None:
        self._connection.close()
        self._process.join(10.0)
        if self._process.is_alive():
            self._process.kill()

    def _ask(self, what: str, path: str, given: Any = None) -> Any:
        with self._lock:
            self._connection.send((what, path, given))
            return self._answer(_ANSWER)

    def _answer(self, patience: float) -> Any:
        assert self._connection.poll(patience), "the rig's process does not answer"
        good, answer = self._connection.recv()
        if not good:
            raise answer
        return answer
