"""Adapter and emulated autopilot on loopback, and waits that end with what they wait for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from virtual_time import CLOCK

from doorman.cli.vehicles.rig_demo import free_port
from doorman.clocks import Clock
from doorman.hardware.pixhawk import (
    AttitudeSetpoint,
    Autopilot,
    Event,
    EventKind,
    PixhawkConfig,
    SampleStatus,
    ThrustCurve,
    Timeouts,
)
from doorman.rig.emulators.autopilot import EmulatedAutopilot

NO = np.zeros(3)
WEIGHT = 3.0 * 9.81
HOVER = AttitudeSetpoint(WEIGHT, NO)
PATIENCE = 8.0
"""Longest wait of a test for something that takes far less [s]."""
PACE = 3.0
"""At which the emulated world runs, where nothing depends on it: flights take a third of the time."""
QUICK = Timeouts(
    open=5.0, state=0.3, stream_before_mode=0.3, mode=4.0, arming=4.0, take_off=10.0, landing=15.0, answer=0.15
)
SAFE = {
    "px4": {"COM_OF_LOSS_T": 1.0, "COM_OBL_RC_ACT": 4, "NAV_RCL_ACT": 3, "COM_DISARM_LAND": 0.2},
    "ardupilot": {
        "GUID_OPTIONS": 8,
        "GUID_TIMEOUT": 0.5,
        "FS_GCS_ENABLE": 5,
        "FS_GCS_TIMEOUT": 4.0,
        "FS_THR_ENABLE": 3,
    },
}
"""Parameters as the check wants them."""


def wait_until(condition: Callable[[], Any], timeout: float = PATIENCE, clock: Clock = CLOCK) -> bool:
    """Whether a condition comes true in time."""
    deadline = clock.now() + timeout
    while not condition():
        if clock.now() > deadline:
            return False
        clock.sleep(0.002)
    return True


class Rig:
    """An emulated autopilot and an adapter that is made for it."""

    def __init__(self, flavour: str, emulator: dict[str, Any], config: dict[str, Any]) -> None:
        self.port = free_port()
        defaults: dict[str, Any] = {
            "remote": ("127.0.0.1", self.port),
            "start_up": 0.0,
            "heartbeat_rate": 10.0,
            "pace": PACE,
            "clock": CLOCK,
        }
        self.clock: Clock = emulator.get("clock", CLOCK)
        self.emulator = EmulatedAutopilot(flavour, **{**defaults, **emulator})  # type: ignore[arg-type]
        for name, value in SAFE[flavour].items():
            self.emulator.parameters[name] = value
        if self.emulator.build.vision:
            for name, value in self.emulator.build.dialect.mocap.items():
                self.emulator.parameters[name] = value
        settings: dict[str, Any] = {"timeouts": QUICK, "thrust_curve": ThrustCurve(0.4, WEIGHT), "climb_rate": 2.0}
        self.config = PixhawkConfig(**{"connection": f"udp:{self.port}", **settings, **config})
        self.pilot = Autopilot(self.config, self.clock)
        self.seen: list[Event] = []

    def open(self) -> Rig:
        """Start both and wait for a fresh state."""
        self.emulator.open()
        self.pilot.open()
        assert wait_until(
            lambda: self.pilot.state().status is SampleStatus.FRESH or self.emulator.build.vision, clock=self.clock
        )
        return self

    def fly(self, height: float = 0.3) -> Rig:
        """Up to hover under our command."""
        self.open()
        for outcome in (self.pilot.engage(), self.pilot.arm(), self.pilot.take_off(height)):
            assert outcome.done, outcome
        return self

    def happens(self, kind: EventKind, begins: bool = True, words: str = "") -> Event:
        """Wait for an event and return it; it is an error if it does not come."""

        def look() -> list[Event]:
            self.seen += self.pilot.events()
            return [one for one in self.seen if one.kind is kind and one.begins is begins and words in one.message]

        assert wait_until(look, clock=self.clock), f"no {kind} '{words}'; seen: {self.seen}"
        return look()[0]

    def forget(self) -> None:
        """Forget the events so far."""
        self.pilot.events()
        self.seen.clear()

    def stop(self) -> None:
        self.pilot._link.config = replace(self.config, on_stop="leave")
        self.pilot.stop()
        self.emulator.stop()


def landed(rig: Rig) -> bool:
    """Whether the vehicle stands on the ground in time, disarmed."""
    return wait_until(lambda: not rig.emulator.brain.armed and rig.emulator.truth.on_ground, clock=rig.clock)


def fresh(rig: Rig) -> bool:
    """Whether the state gets fresh in time."""
    return wait_until(lambda: rig.pilot.state().status is SampleStatus.FRESH, clock=rig.clock)
