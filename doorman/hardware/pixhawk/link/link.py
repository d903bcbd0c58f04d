"""The thread that talks to the autopilot: reads, keeps time, streams, watches; no other thread touches the line."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

from doorman.background import InThread
from doorman.clocks import BRIEFLY, LONGEST_WAIT, LOOK, REAL_TIME, Clock
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.config import HEARTBEAT, PROMPT, PixhawkConfig
from doorman.hardware.pixhawk.events import EventKind, Outcome, OutcomeStatus
from doorman.hardware.pixhawk.link.exchange import Answer
from doorman.hardware.pixhawk.link.inbox import WANTED, Inbox
from doorman.hardware.pixhawk.link.mocap import MocapOutlet
from doorman.hardware.pixhawk.link.stream import here
from doorman.hardware.pixhawk.link.watchdog import Watchdog
from doorman.hardware.pixhawk.wire.codec import Codec, load_key
from doorman.hardware.pixhawk.wire.connection import parse_connection
from doorman.hardware.pixhawk.wire.messages import Message, command_message, mavlink
from doorman.hardware.pixhawk.wire.transport import DeviceLost, Line, open_line

_LONGEST_SLEEP = 3 * BRIEFLY
"""What other threads send waits for so long at most [s]."""
_TRIES = 5
_CANCELLED = 6
"""MAV_RESULT that pymavlink's dialect lacks."""
_LONGEST_PROGRESS, _NEXT_PROGRESS = 30 * HEARTBEAT, 2 * HEARTBEAT
"""Longest wait for a command in progress: in all, and until the next acknowledgement [s]."""


class _Timer:
    def __init__(self, period: float) -> None:
        self.period = period
        self.next = 0.0

    def due(self, now: float) -> bool:
        if now < self.next:
            return False
        self.next = max(self.next + self.period, now + 0.5 * self.period)
        return True


class Link(Inbox, InThread):
    """The line to one autopilot, with what is known of it; it is opened once."""

    def __init__(self, config: PixhawkConfig, time: Clock = REAL_TIME) -> None:
        InThread.__init__(self, "pixhawk", time)
        Inbox.__init__(self, config, time)
        self.mocap = MocapOutlet(config.local_frame, config.rates.mocap, config.timeouts.mocap)
        self._endpoint = parse_connection(config.connection)
        self._watchdog = Watchdog(config, self.events)
        self._line: Line | None = None
        self._reopen_at = 0.0
        rates = config.rates
        self._heartbeat, self._sync = _Timer(1.0 / rates.heartbeat), _Timer(1.0 / rates.timesync)
        self._setpoint, self._look = _Timer(1.0 / rates.setpoint), _Timer(1.0 / rates.setpoint)

    # ------------------------------------------------------------ from any thread

    def send(self, message: Message) -> None:
        """Queue a message; it goes out within milliseconds and in order, or never where the line is gone."""
        if self._line is not None:
            self._outgoing.append(message)

    def request_landing(self) -> bool:
        """Hold here, without the controller, and ask to land until the heartbeat shows it; False if the vehicle is not ours."""
        sample = self.tracker.sample
        fresh = sample.age(self.time.now()) <= self.config.timeouts.state
        return self.authority.request_landing(here(sample) if fresh else None)

    def until(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Whether a condition comes true in time."""
        return self.exchange.wait(lambda: True if condition() else None, timeout) is not None

    def command(
        self, number: int, *parameters: float, tries: int = _TRIES, go_on: Callable[[], bool] = lambda: True
    ) -> Outcome:
        """COMMAND_LONG and its acknowledgement: sent again while no answer comes, awaited while it is in progress."""
        started, start = self.time.now(), self.exchange.count
        for confirmation in range(tries):
            self.send(command_message(self.target, number, *parameters, confirmation=confirmation))
            if (answer := self._answer(number, start)) is not None:
                return self._outcome(number, int(answer.value), started)
            if not (self.alive and go_on()):
                break
        text = f"command {number} was not acknowledged, sent {confirmation + 1} times"
        self.events.happen(EventKind.COMMAND_UNANSWERED, self.time.now(), text, command=number)
        return Outcome(OutcomeStatus.TIMED_OUT, text)

    def _answer(self, number: int, after: int) -> Answer | None:
        """Final acknowledgement of a command; those that say "in progress" prolong the wait."""
        timeout, deadline = self.config.timeouts.answer, self.time.now() + _LONGEST_PROGRESS
        while True:
            answer = self.exchange.wait(lambda after=after: self.exchange.answer(number, after), timeout)  # type: ignore[misc]
            if answer is None or answer.value != mavlink.MAV_RESULT_IN_PROGRESS or self.time.now() > deadline:
                return answer
            after, timeout = answer.number, max(timeout, _NEXT_PROGRESS)

    def _outcome(self, number: int, result: int, started: float) -> Outcome:
        if result == mavlink.MAV_RESULT_ACCEPTED:
            return Outcome(OutcomeStatus.DONE)
        self.until(lambda: bool(self.exchange.texts(started)), PROMPT)  # reasons may follow a refusal
        known = mavlink.enums["MAV_RESULT"].get(result)
        name = f"result {result}" if known is None else known.name.removeprefix("MAV_RESULT_").lower().replace("_", " ")
        words = "cancelled" if result == _CANCELLED else name
        text = ": ".join(filter(None, (f"command {number} {words}", "; ".join(self.exchange.texts(started)))))
        self.events.happen(EventKind.COMMAND_REFUSED, self.time.now(), text, command=number, result=result)
        return Outcome(OutcomeStatus.REFUSED, text)

    def _begin(self) -> None:
        config = self.config
        key = None if config.signing_key is None else load_key(config.signing_key)
        self.codec = Codec(config.system_id, config.component_id, key, WANTED)
        self._line = open_line(self._endpoint, config.timeouts.open)
        self._endpoint = self._line.endpoint

    def _end(self) -> None:
        if self._line is not None:
            self._line.close()
            self._line = None
        self.exchange.wake()

    # ------------------------------------------------------------ the thread

    def _run(self) -> None:
        try:
            while not self._stopping.is_set():
                self._once()
        except Exception as error:  # noqa: BLE001  # nothing may be raised out of the thread unseen
            self.events.happen(EventKind.IO_FAILED, self.time.now(), f"{type(error).__name__}: {error}")
            self.authority.rebooted(self.time.now())
            self.events.condition(EventKind.LINK_LOST, True, self.time.now(), "the thread of the link failed")
        finally:
            self.exchange.wake()

    def _once(self) -> None:
        line = self._line
        if line is None:
            self._reopen()
            return
        try:
            self.time.readable([line], self._sleep_time(self.time.now()))
            received = line.receive()
            for data, address in received:
                self.receive(data, address, line)
            self._send_due(line, self.time.now())
        except (DeviceLost, OSError, ValueError) as error:  # ValueError: waiting for a descriptor that is gone
            self._lose_device(error)
            return
        now = self.time.now()
        self._watch(now)
        if received:
            self.exchange.wake()

    def _sleep_time(self, now: float) -> float:
        until = min(self._heartbeat.next, self._sync.next, self._setpoint.next) - now
        return 0.0 if self._outgoing else min(max(until, 0.0), _LONGEST_SLEEP)

    def _send_due(self, line: Line, now: float) -> None:
        while self._outgoing:
            self._transmit(line, self._outgoing.popleft())
        if self._heartbeat.due(now):
            kind = mavlink.MAV_TYPE_GCS if self.config.ground_station else mavlink.MAV_TYPE_ONBOARD_CONTROLLER
            state = mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
            self._transmit(line, mavlink.MAVLink_heartbeat_message(kind, *state))
        identity, dialect = self.identity, self.dialect
        if identity is None or dialect is None:
            self._setpoint.next = self._sync.next = now + _LONGEST_SLEEP
            return
        origin, armed = self.origin, self.tracker.sample.armed
        settled = origin is None or origin.settled(now, armed)
        pose = self.mocap.message(now) if settled and not line.busy else None
        if pose is not None:  # first: setpoints, of which there are more, would leave a slow line no room for them
            self._transmit(line, pose)
        if self._setpoint.next <= now and line.busy:
            self._setpoint.next = now + BRIEFLY  # made anew then
        elif self._setpoint.due(now):
            setpoint = self.stream.message(now, self.tracker.sample, identity)
            if setpoint is not None:
                self._transmit(line, setpoint)
            elif self.stream.stranded and not dialect.needs_stream:
                self.authority.request_landing(None)
        if self._sync.due(now):
            if not self.clock.synchronised:
                self._sync.next = now + self._sync.period / 5
            self._transmit(line, mavlink.MAVLink_timesync_message(0, self.clock.ask(self.time.nanoseconds())))
        requests = [] if origin is None else origin.messages(now, identity, armed)
        for request in (
            *requests, *self.authority.requests(now, dialect, identity), *self.rates.requests(now, identity)
        ):  # fmt: skip
            self._transmit(line, request)

    def _transmit(self, line: Line, message: Message) -> None:
        assert self.codec is not None
        if self.config.listen_only:
            return
        line.send(self.codec.encode(message))

    def _watch(self, now: float) -> None:
        if self.identity is None or not self._look.due(now):
            return
        sample, pose = self.tracker.sample, self.mocap.newest_time if self.config.mocap else float("-inf")
        self._watchdog.check(now, self.last_message, sample, self.clock, None if pose == float("-inf") else pose)
        lost = EventKind.MOCAP_LOST in self.events.conditions
        if lost and self.config.on_mocap_loss == "land" and sample.armed and not self.authority.landing_requested:
            self.request_landing()

    def _lose_device(self, error: Exception) -> None:
        now = self.time.now()
        self.events.condition(EventKind.DEVICE_LOST, True, now, f"the line is gone: {error}")
        if self._line is not None:
            with contextlib.suppress(OSError):
                self._line.close()
        self._line = None
        self._outgoing.clear()
        self._reopen_at = now + LONGEST_WAIT

    def _reopen(self) -> None:
        now = self.time.now()
        self._watch(now)
        if now < self._reopen_at:
            self._stopping.wait(min(self._reopen_at - now, LOOK))
            return
        self._reopen_at = now + LONGEST_WAIT
        try:
            line = open_line(self._endpoint, 2 * LONGEST_WAIT)
        except BackendError:
            return
        if self._stopping.is_set():
            line.close()
            return
        line.peer = line.peer or self.peer.address
        self._outgoing.clear()
        self._line = line
        self.rates.restart()
        self.events.condition(EventKind.DEVICE_LOST, False, now, "the line is gone")
