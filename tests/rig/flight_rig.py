"""A rig with links on it, and one flight after another through both."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar, Literal, cast

import numpy as np
from far_rig import FarRig

from doorman.cli.vehicles.rig_demo import free_port
from doorman.flight import FlightReport, FlightSession
from doorman.hardware.pixhawk import SampleStatus, Timeouts
from doorman.hardware.vehicle import VehicleConfig, VehicleLinks, vehicle_config
from doorman.hardware.vehicle.places import Places
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder, Recording
from doorman.rig import RigSetup
from doorman.rig.plant import Snapshot
from doorman.scenario import SafetySection, Scenario

SCENARIO = os.environ.get("DOORMAN_RIG_SCENARIO", "paper")
"""Whose missions are flown: `paper` or `push`."""
AUTOPILOT = cast("Literal['px4', 'ardupilot']", os.environ.get("DOORMAN_RIG_AUTOPILOT", "px4"))
"""Whose rules the emulated autopilot follows."""
PATIENCE = 60.0
"""Longest wait for something that takes far less [s]."""

_STEADY = 20
"""Looks at the links, 20 ms apart, that must find them fresh and agreeing before a flight."""

LONGEST = 140.0
"""Longest that a session takes to end: it waits a minute for motors that nobody reports to have stopped [s]."""


def until(condition: Callable[[], Any], what: str, tell: Callable[[], object] = lambda: "") -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < deadline, (f"not in time: {what}", tell())
        time.sleep(0.01)


def quick(config: VehicleConfig) -> VehicleConfig:
    """The same vehicle with shorter ways to the air, and more patience with a busy computer."""
    timeouts = Timeouts(stream_before_mode=0.3, state=0.4, answer=0.3, arming=8.0)
    pixhawk = replace(
        config.pixhawk, timeouts=timeouts, climb_rate=1.0, rates=replace(config.pixhawk.rates, setpoint=100.0)
    )
    assert config.mocap is not None
    mocap = replace(config.mocap, stale_after=0.08, prediction_limit=0.4)
    servos = replace(config.servos, rate=100.0, latency=0.015, stale_after=0.15, watchdog=0.3, command_timeout=0.3)
    return replace(config, pixhawk=pixhawk, mocap=mocap, servos=servos, rate=100.0, servo_patience=0.4)


class _BusyComputer(SafetySection):
    missed_ticks: ClassVar = 2.0


class FlightRig:
    """Rig and links that stay open, and a planner that stays compiled.

    Args:
        folder: For the link to the servos.
    """

    def __init__(self, folder: Path) -> None:
        scenario = Scenario.load(
            SCENARIO,
            {
                "planner.rate": 25.0,
                "safety.divergence": 0.3,
                "mission.time_out.hold": 12.0,
            },
        )
        safety = scenario.safety.model_dump(exclude_unset=True)
        self.model = Model(scenario.model_copy(update={"safety": _BusyComputer(**safety)}))
        self.places = Places.of(self.model)
        self.planner = Planner(self.model)
        setup = RigSetup(AUTOPILOT, free_port(), free_port(), folder, heartbeat_rate=10.0)
        self.far = FarRig(scenario, setup)
        if AUTOPILOT == "px4":
            self.far.call("rig.autopilot.parameters.__setitem__", "COM_DISARM_LAND", 0.3)
        words = self.far.arguments
        self.links = VehicleLinks(
            quick(vehicle_config(self.model, words[1], words[3], words[5], on_mocap_loss="report"))
        )
        self._collisions: list[str] = []

    def open(self) -> None:
        self.links.open()
        until(lambda: self.links.autopilot.state().status is SampleStatus.FRESH, "the autopilot's state")

    def stop(self) -> None:
        self.links.stop()
        self.far.stop()

    @property
    def snapshot(self) -> Snapshot:
        """The plant as it is now."""
        return cast(Snapshot, self.far.get("rig.plant.snapshot"))

    def heal(self) -> None:
        """End every fault, and bring the vehicle back to its pad."""
        self.far.call("calm")
        self.links.release()
        until(lambda: not self.links.autopilot.state().armed, "disarmed")
        self.far.call("rig.plant.reset")
        until(lambda: self.links.autopilot.state().status is SampleStatus.FRESH, "a fresh state")
        until(lambda: self.links.mocap.read().fresh, "a fresh pose")
        until(lambda: not self.links.servos.recover(5.0), "servos set up again")
        until(lambda: self.links.servos.read().fresh, "fresh servos")
        until(lambda: float(self.links.autopilot.state().position[2]) < 0.3, "on the pad")
        # a jump that ends, and the way back to the pad, are outliers to a gate that may not have seen them yet
        for _ in range(_STEADY):
            until(lambda: self.links.mocap.read().fresh and self.disagreement < 0.05, "cameras and autopilot agree")
            time.sleep(0.02)
        self._collisions = self.far.get("collisions")

    @property
    def collided(self) -> set[str]:
        """What touched what since it healed."""
        return set(self.far.get("collisions")[len(self._collisions) :])

    @property
    def disagreement(self) -> float:
        """Between cameras and autopilot [m]."""
        return float(np.linalg.norm(self.links.mocap.read().position - self.links.autopilot.state().position))

    def flight(self, recording: Path | None = None) -> Flight:
        return Flight(self, recording)


class Flight:
    """One session in a thread of its own.

    Args:
        rig: The rig.
        recording: File to record to, besides memory.
    """

    def __init__(self, rig: FlightRig, recording: Path | None = None) -> None:
        self.rig = rig
        self.recorder = Recorder(recording, {})
        self.said: list[str] = []
        self.session = FlightSession(rig.model, rig.links, rig.planner, self.recorder, self.said.append)
        self.on_progress: Callable[[], None] = lambda: None
        self._report: FlightReport | None = None
        self._thread = threading.Thread(target=self._fly, daemon=True)

    def begin(self) -> Flight:
        self._thread.start()
        return self

    def until_phase(self, *phases: str) -> Flight:
        """Wait until the mission flies, in one of these phases."""
        until(lambda: self._report or (self.session.backend.commanding and self.session.phase in phases), str(phases),
              lambda: (self.told(), self.rig.snapshot))  # fmt: skip
        assert self._report is None, (self._report, self.told())
        return self

    def end(self) -> FlightReport:
        self._thread.join(LONGEST)
        assert self._report is not None, ("the session does not end", self.told())
        return self._report

    def told(self) -> object:
        """What the session did, and what the links and the supervisor told last."""
        self.session.journal.take(self.session.backend.epoch)
        return self.session.phase, self.said, self.session.supervisor.findings, self.session.journal.lines[-12:]

    @property
    def report(self) -> FlightReport | None:
        """What became of it; None before its end."""
        return self._report

    @property
    def recording(self) -> Recording:
        return self.recorder.recording()

    def _fly(self) -> None:
        self._report = self.session.fly(None, lambda now, door_angle: self.on_progress())
