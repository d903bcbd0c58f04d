"""Who commands the vehicle: this computer only while the autopilot says so in its heartbeat; the radio always wins."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from threading import RLock

from doorman.hardware.pixhawk.config import PROMPT, Timeouts
from doorman.hardware.pixhawk.dialect import Dialect, Mode
from doorman.hardware.pixhawk.events import EventKind, LinkLog
from doorman.hardware.pixhawk.link.stream import SetpointStream
from doorman.hardware.pixhawk.setpoints import PositionSetpoint
from doorman.hardware.pixhawk.wire.messages import Message, command_message, mavlink

_LANDING_COMMANDS = (mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_CMD_NAV_LAND)
_TERMINATED = mavlink.MAV_STATE_FLIGHT_TERMINATION
"""PX4 says so while a kill switch holds its motors: still armed, in the mode that it had, for 5 s."""
_FAILSAFE_STATUS = frozenset({mavlink.MAV_STATE_CRITICAL, mavlink.MAV_STATE_EMERGENCY, _TERMINATED})


class Authority(Enum):
    """Whether setpoints are obeyed."""

    NONE = "none"
    PREPARING = "preparing"
    """Setpoints stream, the mode has not changed yet."""
    ENGAGED = "engaged"
    LANDING = "landing"
    """We asked the autopilot to land, and it does."""
    LOST = "lost"
    """Someone else changed the mode."""


_OURS = frozenset({Authority.PREPARING, Authority.ENGAGED, Authority.LANDING})


class AuthorityKeeper:
    """Follows the heartbeat's mode and stops the stream when it is not ours; asks for landing until it is confirmed."""

    def __init__(self, stream: SetpointStream, events: LinkLog, timeouts: Timeouts = Timeouts()) -> None:
        self._stream, self._events, self._timeouts, self._lock = stream, events, timeouts, RLock()
        self.state = Authority.NONE
        self._mode: Mode | None = None
        self._armed = False
        self.disarm_expected = False  # whether we asked for it
        self.landing_requested = False
        self._next_request, self._requests = 0.0, 0

    def prepare(self) -> None:
        with self._lock:
            self.state = Authority.PREPARING
            self.landing_requested = self.disarm_expected = False

    def withdraw(self, now: float) -> None:
        with self._lock:
            self._end(Authority.NONE, now)

    def if_engaged(self, act: Callable[[SetpointStream], None]) -> bool:
        """Change the stream, if the vehicle is ours."""
        with self._lock:
            if self.state is Authority.ENGAGED:
                act(self._stream)
            return self.state is Authority.ENGAGED

    def hold(self, place: PositionSetpoint, *, latch: bool) -> bool:
        return self.if_engaged(lambda stream: stream.hold(place, latch=latch))

    def request_landing(self, place: PositionSetpoint | None) -> bool:
        """Ask to land at every chance until the heartbeat shows it; refused unless the vehicle is ours."""
        with self._lock:
            if self.state is Authority.LANDING or self.landing_requested:  # asked again and again as it is
                return True
            if self.state is not Authority.ENGAGED:
                return False
            if place is not None:
                self._stream.hold(place, latch=True)
            self.landing_requested, self._next_request, self._requests = True, 0.0, 0
            return True

    def requests(self, now: float, dialect: Dialect, target: tuple[int, int]) -> list[Message]:
        """Requests to land that are due: by mode, and every other time by command."""
        with self._lock:
            if not self.landing_requested or now < self._next_request:
                return []
            before = self._requests
            self._next_request, self._requests = now + PROMPT, before + 1
            number, parameters = mavlink.MAV_CMD_DO_SET_MODE, [*dialect.mode_parameters(dialect.land_mode)]
            if before % 2:
                number, parameters = mavlink.MAV_CMD_NAV_LAND, [0.0, 0.0, 0.0, *[dialect.no_place] * 3]
            return [command_message(target, number, *parameters, confirmation=min(255, before))]

    def accepted(self, command: int, now: float) -> None:
        with self._lock:
            if self.landing_requested and command in _LANDING_COMMANDS:
                self._next_request = now + self._timeouts.stop  # a mode that a pilot chooses meanwhile is not overruled

    def heartbeat(self, mode: Mode, armed: bool, system_status: int, dialect: Dialect, now: float) -> None:
        with self._lock:
            self._note_changes(mode, armed, now)
            if system_status == _TERMINATED:
                if self.state in _OURS:
                    self._lose("the motors were stopped: kill switch, or flight termination", now)
            elif self.state is Authority.PREPARING and mode == dialect.companion_mode:
                self.state = Authority.ENGAGED
                self._events.condition(EventKind.CONTROL_LOST, False, now, "another mode")
            elif self.state is Authority.ENGAGED and mode != dialect.companion_mode:
                if self.landing_requested and mode in dialect.land_modes:
                    self._end(Authority.LANDING, now)
                else:
                    self._lose(f"mode is {mode}", now)
            elif self.state is Authority.LANDING and mode not in dialect.land_modes and armed:
                self._lose(f"mode is {mode} while landing", now)  # disarmed, PX4 goes back to the mode before
            if self._armed and not armed:
                self._disarmed(now)
            self._armed, self._mode = armed, mode
            critical, words = system_status in _FAILSAFE_STATUS, "the autopilot reports a critical state"
            self._events.condition(EventKind.AUTOPILOT_FAILSAFE, critical, now, words, status=system_status)

    def rebooted(self, now: float) -> None:
        """Take in that the autopilot has started anew, and obeys nothing from before."""
        with self._lock:
            if self.state is not Authority.NONE:
                self._lose("the autopilot rebooted", now)
            self._mode, self._armed = None, False

    def _disarmed(self, now: float) -> None:
        expected = self.disarm_expected or self.landing_requested
        if self.state is Authority.LANDING or (self.state is Authority.ENGAGED and expected):
            self._end(Authority.NONE, now)
        elif self.state is Authority.ENGAGED:
            self._lose("the autopilot disarmed", now)

    def _lose(self, why: str, now: float) -> None:
        self._end(Authority.LOST, now)
        self._events.condition(EventKind.CONTROL_LOST, True, now, why)

    def _end(self, state: Authority, now: float) -> None:
        """Command nothing any more."""
        self._stream.stop()
        self.state, self.landing_requested = state, False
        self._events.condition(EventKind.SETPOINT_STALE, False, now, "the stream is off")

    def _note_changes(self, mode: Mode, armed: bool, now: float) -> None:
        if self._mode is not None and mode != self._mode:
            self._events.happen(EventKind.MODE_CHANGED, now, f"{self._mode} to {mode}", number=mode.number)
        if armed != self._armed:
            kind = EventKind.ARMED if armed else EventKind.DISARMED
            self._events.happen(kind, now, kind.value)
