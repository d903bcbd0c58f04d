"""The stream of setpoints: what to tell the autopilot at each of its ticks, and what to do when the controller falls silent."""

from __future__ import annotations

import math
from enum import Enum
from threading import Lock

import numpy as np

from doorman.hardware.pixhawk.config import PixhawkConfig
from doorman.hardware.pixhawk.events import EventKind, LinkLog
from doorman.hardware.pixhawk.sample import VehicleSample
from doorman.hardware.pixhawk.setpoints import (
    AttitudeSetpoint,
    PositionSetpoint,
    Setpoint,
    StraightWay,
    attitude_message,
    position_message,
)
from doorman.hardware.pixhawk.thrust.curve import ThrustCurve
from doorman.hardware.pixhawk.thrust.slope import ThrustModel
from doorman.hardware.pixhawk.wire.messages import Message, seconds_to_boot_ms

LONGEST_BLIND_HOLD = 1.0
"""A position older than this [s] is no place to hold: the stream ends. PX4's own failsafe acts then; ArduPilot, which would
level and drift as long as heartbeats come, is commanded to land."""


LEVELLING = 0.25
"""A hold that follows attitude setpoints begins level for so long [s], where the autopilot would keep the tilt: ArduPilot's
position control takes it for what wind asks for, and a vehicle that leant on a door would go on towards it; PX4's brakes at
once."""


class Source(Enum):
    """Source of the setpoints."""

    OFF = "no one"
    HOLD = "a fixed point"
    CLIMB = "take-off"
    CONTROLLER = "the controller"


class SetpointStream:
    """Latest-sample exchange with the controller, and the message of each tick."""

    def __init__(self, config: PixhawkConfig, events: LinkLog) -> None:
        self.curve: ThrustCurve | None = config.thrust_curve
        self.thrust_model: ThrustModel | None = None
        """How the autopilot undoes the motors' curve; None until it has said so."""
        self.angle_boost = False  # whether the autopilot divides thrust by the cosine of the commanded tilt
        self.keeps_tilt = True  # whether the autopilot's position control begins with the tilt that it finds
        self.longest_gap = 0.0  # between two messages of the stream [s]
        self._config = config
        self._events = events
        self._lock = Lock()
        self.source = Source.OFF  # who says where to fly
        self.latched = False  # whether the controller is kept out until `release`
        self._hold: PositionSetpoint | None = None
        self._climb: StraightWay | None = None
        self._latest: tuple[Setpoint, float] | None = None
        self._last_sent: float | None = None
        self._leans, self._yaw = False, 0.0
        self._level_since: float | None = None
        self._nowhere = False

    def offer(self, setpoint: Setpoint, now: float) -> bool:
        with self._lock:
            if self.latched or self.source in (Source.OFF, Source.CLIMB):
                return False
            self._latest = (setpoint, now)
            self.source = Source.CONTROLLER
        return True

    def hold(self, setpoint: PositionSetpoint, *, latch: bool = False) -> None:
        with self._lock:
            self._hold, self.source, self.latched = setpoint, Source.HOLD, latch

    def climb(self, start: PositionSetpoint, height: float, now: float) -> None:
        with self._lock:
            top = start.position + np.array([0.0, 0.0, height])
            self._climb = StraightWay(now, start.position, top, start.yaw, start.yaw, self._config.climb_rate)
            self.source, self.latched = Source.CLIMB, False

    @property
    def stranded(self) -> bool:
        return self.source is Source.CONTROLLER and self._nowhere

    def release(self) -> None:
        with self._lock:
            self.latched = False

    def stop(self) -> None:
        with self._lock:
            self.source, self.latched, self._latest = Source.OFF, False, None
            self._last_sent = None

    def message(self, now: float, sample: VehicleSample, target: tuple[int, int]) -> Message | None:
        with self._lock:
            setpoint, hold = self._current(now, sample)
            setpoint = self._levelled(setpoint, hold, now)
        if setpoint is None:
            self._last_sent = None
            return None
        if self._last_sent is not None:
            self.longest_gap = max(self.longest_gap, now - self._last_sent)
        self._last_sent = now
        boot_ms, frame = seconds_to_boot_ms(now), self._config.local_frame
        if isinstance(setpoint, PositionSetpoint):
            return position_message(setpoint, frame, boot_ms, target, hold=hold)
        curve, force, voltage = self.curve, setpoint.thrust, sample.battery.voltage
        assert curve is not None, "attitude setpoints are refused without a thrust curve"
        if self.angle_boost:
            force *= max(0.1, math.cos(float(setpoint.attitude[0])) * math.cos(float(setpoint.attitude[1])))
        thrust, side = curve.normalised(force, voltage), None
        if self._config.rotors is not None:
            scales = zip(self._config.rotors.side_scale, setpoint.side_force, strict=True)
            side = [scale * curve.beside(part, thrust, voltage) for scale, part in scales]
        return attitude_message(setpoint, thrust, frame, boot_ms, target, side)

    def _current(self, now: float, sample: VehicleSample) -> tuple[Setpoint | None, bool]:
        if self.source is Source.HOLD:
            return self._hold, True
        if self.source is Source.CLIMB and self._climb is not None:
            return self._climb.setpoint(now), True
        if self.source is not Source.CONTROLLER or self._latest is None:
            return None, False
        setpoint, given = self._latest
        silent = now - given
        stale = silent > self._config.timeouts.setpoint
        changed = self._events.condition(
            EventKind.SETPOINT_STALE, stale, now, "the controller sends no setpoints", silent=silent
        )
        if not stale:
            self._nowhere = False
            return setpoint, False
        if changed:
            self._hold = here(sample) if now - sample.position_time < LONGEST_BLIND_HOLD else None
            self._nowhere = self._hold is None
        return self._hold, True

    def _levelled(self, setpoint: Setpoint | None, hold: bool, now: float) -> Setpoint | None:
        """The setpoint, or a level attitude where a hold, or nothing, begins to replace attitude setpoints."""
        if not hold:
            self._leans, self._level_since = isinstance(setpoint, AttitudeSetpoint), None
            if isinstance(setpoint, AttitudeSetpoint):
                self._yaw = float(setpoint.attitude[2])
            return setpoint
        if not self._leans or self.curve is None or (setpoint is not None and not self.keeps_tilt):
            return setpoint
        if self._level_since is None:
            self._level_since = now
        if now - self._level_since < LEVELLING:
            yaw = setpoint.yaw if isinstance(setpoint, PositionSetpoint) else self._yaw
            return AttitudeSetpoint(self.curve.hover_force, np.array([0.0, 0.0, yaw]))
        self._leans = False
        return setpoint


def here(sample: VehicleSample) -> PositionSetpoint | None:
    """Setpoint to stay where the vehicle is; None while that is unknown."""
    yaw = float(sample.attitude[2])
    if not (np.isfinite(sample.position).all() and math.isfinite(yaw)):
        return None
    return PositionSetpoint(sample.position.copy(), yaw)
