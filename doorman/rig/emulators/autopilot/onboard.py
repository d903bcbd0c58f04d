"""What runs on the emulated autopilot and is gone after a reboot: estimator, modes, controller, protocol, clock."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Literal

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.rig.emulators.autopilot.allocation import side_force
from doorman.rig.emulators.autopilot.ardupilot import ArduPilotBrain
from doorman.rig.emulators.autopilot.brain import Brain, Surroundings
from doorman.rig.emulators.autopilot.control import FlightController, Task
from doorman.rig.emulators.autopilot.estimator import Estimator
from doorman.rig.emulators.autopilot.motors import FACTORS, MotorKind, Motors
from doorman.rig.emulators.autopilot.parameters import ParameterStore
from doorman.rig.emulators.autopilot.plant import GRAVITY, AutopilotPlant
from doorman.rig.emulators.autopilot.protocol import Protocol
from doorman.rig.emulators.autopilot.px4 import Px4Brain
from doorman.rig.emulators.autopilot.schedule import (
    ARDUPILOT_RATES,
    PX4_RATES,
    PX4_SETTABLE,
    SETTABLE,
    Schedule,
)
from doorman.rig.emulators.autopilot.telemetry import EmulatedBattery, Telemetry, estimator_status

_BOOT_CLOCK = 3.0
"""Reading of the clock when the link comes up [s]."""
_EPOCH_2015 = 1_420_070_400
Flavour = Literal["px4", "ardupilot"]


@dataclass(frozen=True)
class Build:
    """What no reboot changes."""

    flavour: Flavour
    vision: bool
    system_id: int
    start_up: float
    heartbeat_rate: float
    vehicle_type: int
    hover_thrust: float
    motors: MotorKind
    signing_key: bytes | None
    seed: int


class Onboard:
    """One life of the autopilot, from boot to reboot.

    Args:
        build: What it is.
        plant: What it flies.
        parameters: Its parameters.
        battery: Its power.
        pace: Of its clock over real time.
        transmit: Sends bytes.
    """

    def __init__(
        self,
        build: Build,
        plant: AutopilotPlant,
        parameters: ParameterStore,
        battery: EmulatedBattery,
        pace: float,
        transmit: Callable[[bytes], None],
    ) -> None:
        px4 = build.flavour == "px4"
        self.heartbeats_stopped = False
        self._build, self._plant, self._transmit, self._pace = build, plant, transmit, pace
        self._started, self._jumped = time.monotonic(), 0.0
        self.brain: Brain = Px4Brain(parameters) if px4 else ArduPilotBrain(parameters, build.start_up)
        self.estimator = Estimator(build.vision, timeout=5.0 if px4 else 10.0, seed=build.seed, px4=px4)
        rates = dict(PX4_RATES if px4 else ARDUPILOT_RATES)
        rates[mavlink.MAVLINK_MSG_ID_HEARTBEAT] = build.heartbeat_rate
        self._schedule = Schedule(rates, PX4_SETTABLE if px4 else SETTABLE)
        self.protocol = Protocol(
            self.brain,
            self.estimator,
            self._schedule,
            self.send,
            self._tell,
            lambda: self.clock,
            lambda: self.uptime,
            build.system_id,
        )
        self.telemetry = Telemetry(self.brain, battery, build.vehicle_type, satellites=not build.vision)
        """What it sends unasked."""
        self._controller = FlightController(plant.weight, GRAVITY)
        self._motors = Motors(build.motors, FACTORS[build.flavour], parameters)
        self._normalised = 0.0
        self._told: set[str] = set()
        self._mav = mavlink.MAVLink(None, build.system_id, mavlink.MAV_COMP_ID_AUTOPILOT1)
        self._mav.robust_parsing = True
        if build.signing_key is not None:
            self._mav.signing.secret_key, self._mav.signing.sign_outgoing = build.signing_key, True
            self._mav.signing.timestamp = int((time.time() - _EPOCH_2015) * 1e5)
        self.estimate = self.estimator.update(self.uptime, plant.truth(), 0.0)
        self._steered = self.estimate.quaternion

    @property
    def uptime(self) -> float:
        """Since boot, by which it counts its own time-outs: that never jumps [s]."""
        return _BOOT_CLOCK + (time.monotonic() - self._started) * self._pace

    @property
    def clock(self) -> float:
        """What its messages are stamped with [s]."""
        return self.uptime + self._jumped

    def jump_clock(self, seconds: float) -> None:
        """Let the clock jump."""
        self._jumped += seconds

    def receive(self, datagram: bytes) -> None:
        """Act on the messages of a datagram."""
        try:
            messages = self._mav.parse_buffer(datagram) or []
        except mavlink.MAVError:
            return
        for message in messages:
            if message.get_type() != "BAD_DATA":
                with self._surviving(message.get_type()):
                    self.protocol.take(message)

    def step(self, dt: float) -> None:
        """Estimate, decide, control, and let the plant move [s]."""
        now, truth = self.uptime, self._plant.truth()
        self.estimate = self.estimator.update(now, truth, dt)
        around = Surroundings(now, self.estimate, truth.on_ground, now - self.protocol.station_heard)
        demand = self.brain.update(around)
        hover_share = self._build.hover_thrust
        full = self._plant.weight / self._motors.normalised(hover_share)  # as it believes, which knows its hover thrust
        if demand.task is Task.IDLE:
            self._plant.stop_motors()
            self._normalised, self._steered = 0.0, self.estimate.quaternion
        else:
            force, self._steered = self._controller.actuate(demand, self.estimate, full)
            self._normalised = min(max(force / full, 0.0), 1.0)
            share = self._motors.share(self._normalised)
            most = self._plant.weight / hover_share
            self._plant.command(share * most, self._steered, side_force(self.brain.parameters, demand.side, most))
        self._plant.advance(dt)

    def speak(self) -> None:
        """Send what is due."""
        now = self.clock
        for identifier in self._schedule.due(self.uptime):
            if identifier == mavlink.MAVLINK_MSG_ID_TIMESYNC:
                self.send(mavlink.MAVLink_timesync_message(0, round(now * 1e9)))
            elif identifier != mavlink.MAVLINK_MSG_ID_HEARTBEAT or not self.heartbeats_stopped:
                with self._surviving(f"message {identifier}"):
                    self._send_if_any(self._message(identifier))
        for severity, text in self.brain.texts:
            self.send(mavlink.MAVLink_statustext_message(severity, text.encode()[:50]))
        self.brain.texts.clear()

    def send(self, message: Any) -> None:
        """Send a message in its own name."""
        data = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) % 256
        self._transmit(data)

    def _message(self, identifier: int) -> Any | None:
        return self.telemetry.message(identifier, self.clock, self.estimate, self._steered, self._normalised)

    def _send_if_any(self, message: Any | None) -> bool:
        if message is not None:
            self.send(message)
        return message is not None

    def _tell(self, identifier: int) -> bool:
        """Send the message that somebody asks for; False if there is none."""
        if identifier == mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS:
            return self._send_if_any(estimator_status(self.clock, self.brain.landed, self.estimator.navigates))
        return self._send_if_any(self._message(identifier))

    @contextmanager
    def _surviving(self, what: str) -> Iterator[None]:
        """Go on after whatever goes wrong with one message, and tell of it once a kind."""
        try:
            yield
        except Exception:
            if what not in self._told:
                logging.getLogger(__name__).exception("the emulated autopilot goes on without this %s", what)
            self._told.add(what)
