"""What to do with a received message: whose it is, whether it is new, and who wants it.

Where the autopilot speaks from, and whether another sender may take its place.

A link without signatures carries whatever somebody sends. A datagram from another address may come from the autopilot, behind a
router that has started anew, or from anybody. On the ground the place may change, and that is reported. While the vehicle is
armed it is reported and refused.
"""

from __future__ import annotations

import struct
from collections import deque

from doorman.clocks import Clock
from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.authority import AuthorityKeeper
from doorman.hardware.pixhawk.config import HEARTBEAT, PixhawkConfig, Timeouts
from doorman.hardware.pixhawk.dialect import ARDUPILOT, MULTIROTORS, PX4, Dialect, dialect_of
from doorman.hardware.pixhawk.events import RARELY, EventKind, LinkLog
from doorman.hardware.pixhawk.link.exchange import Exchange, StatusText, TextParts
from doorman.hardware.pixhawk.link.origin import CautiousOrigin, Origin
from doorman.hardware.pixhawk.link.rates import RateKeeper
from doorman.hardware.pixhawk.link.stream import SetpointStream
from doorman.hardware.pixhawk.link.timesync import ClockMap, SyncResult
from doorman.hardware.pixhawk.link.tracker import TELEMETRY, Tracker
from doorman.hardware.pixhawk.wire.codec import Codec
from doorman.hardware.pixhawk.wire.messages import IDENTIFIERS, Message, mavlink
from doorman.hardware.pixhawk.wire.transport import Address, Line

_MOST_REPORTS = 20
"""Most reports of senders between two heartbeats, each once: a flood of them does not fill the log."""
_TAKEN = "taken after silence"


class PeerKeeper:
    """Keeps the address that the autopilot speaks from; used by the thread of the link only."""

    def __init__(self, events: LinkLog, signed: bool, patience: float = Timeouts.heartbeat) -> None:
        self.address: Address = None
        """Where the autopilot speaks from; None until it is heard, and on a line with one sender."""
        self._events, self._signed = events, signed
        self._patience = patience  # silence after which the autopilot may speak from another address [s]
        self._reported: dict[object, float] = {}

    def heard(self, address: Address, line: Line, beats: bool, silent: float, armed: bool, now: float) -> None:
        """Take in that a message with the autopilot's ids, its heartbeat or another one, came from an address."""
        if address is None or address == line.peer:
            return
        taken = beats and (line.peer is None or silent == float("inf"))
        if not taken and line.peer is not None:
            if armed and not self._signed:
                what = "refused while armed"
            elif not beats:
                what = "ignored until a heartbeat comes from there"
            else:
                what = "ignored while the autopilot is heard" if silent <= self._patience else _TAKEN
            places = f"{address[0]}:{address[1]} instead of {line.peer[0]}:{line.peer[1]}"
            words = f"the autopilot's ids come from {places}: {what}"
            taken = what is _TAKEN
            self._note((address, what), words, now, address=address, taken=taken)
        if taken:
            line.peer = self.address = address

    def another(self, sender: tuple[int, int], identity: tuple[int, int], now: float) -> None:
        """Take in that another autopilot's heartbeat came from where ours speaks: it is never obeyed."""
        self._note(
            sender, f"refused: system {sender[0]}, component {sender[1]} sends from the address of system {identity[0]}", now,
            system=sender[0], component=sender[1], taken=False,
        )  # fmt: skip

    def _note(self, what: object, words: str, now: float, **values: object) -> None:
        self._reported = {key: time for key, time in self._reported.items() if now - time < HEARTBEAT}
        if what not in self._reported and len(self._reported) < _MOST_REPORTS:
            self._reported[what] = now
            self._events.happen(EventKind.PEER_CHANGED, now, words, **values)


_STATUS_RATE = 5 / HEARTBEAT
"""Rate of what says how the vehicle is, rather than where [1/s]."""
_UNORDERED = frozenset({"COMMAND_ACK", "PARAM_VALUE", "STATUSTEXT", "TIMESYNC"})
"""Worth reading though overtaken."""
_ORDERED = ("HEARTBEAT", "GPS_GLOBAL_ORIGIN", "ESTIMATOR_STATUS", *TELEMETRY)
WANTED = frozenset(IDENTIFIERS[name] for name in (*_UNORDERED, *_ORDERED))
"""Identifiers of the messages that are decoded at all."""


class Inbox:
    """What is known of one autopilot, filled by its messages."""

    def __init__(self, config: PixhawkConfig, time: Clock) -> None:
        self.config, self.time = config, time
        self.events, self.exchange, self.clock = LinkLog(), Exchange(time), ClockMap()
        self.tracker = Tracker(self.clock, config.local_frame, config.timeouts)
        self.stream = SetpointStream(config, self.events)
        self.authority = AuthorityKeeper(self.stream, self.events, config.timeouts)
        self.rates = RateKeeper(wanted_rates(config))
        self.codec: Codec | None = None
        self.identity: tuple[int, int] | None = None  # system and component of the autopilot, once heard
        self.dialect: Dialect | None = None
        self.vehicle_type: int | None = None  # MAV_TYPE of its heartbeat
        self.peer = PeerKeeper(self.events, config.signing_key is not None, config.timeouts.heartbeat)
        self.last_message = float("-inf")  # when it was last heard [s]
        self.foreign = 0  # messages of others
        self.namesake = float("-inf")  # when somebody else's heartbeat with our system id came [s]
        self.origin: Origin | None = None  # gives it a place on earth; None where it needs none, or is not known yet
        self._asks_estimator = False
        """Whether positions are believed only where the autopilot says so: no camera would contradict them."""
        self._outgoing: deque[Message] = deque()
        self._noted = (0, 0, 0, 0)
        self._texts = TextParts()

    @property
    def target(self) -> tuple[int, int]:
        if self.identity is None:
            raise BackendError("no autopilot has been heard yet", allowed="open() first")
        return self.identity

    @property
    def known_dialect(self) -> Dialect:
        if self.dialect is None:
            raise BackendError("no autopilot has been heard yet", allowed="open() first")
        return self.dialect

    def receive(self, data: bytes, address: Address, line: Line) -> None:
        assert self.codec is not None
        now = self.time.now()
        for message in self.codec.decode(data, address):
            self._sort(message, address, line, now)
        if self.codec.outdated and line.peer is None:
            line.peer = self.peer.address = address  # without a clock of its own it takes the time from us
        self._tell(self._texts.late(now))
        self._note_damage(now)

    def _sort(self, message: Message, address: Address, line: Line, now: float) -> None:
        kind, sender = message.get_type(), (message.get_srcSystem(), message.get_srcComponent())
        beats = kind == "HEARTBEAT" and self._meet(message, sender, address, line, now)
        if sender == self.identity:
            self.peer.heard(address, line, beats, now - self.last_message, self.tracker.sample.armed, now)
        if sender != self.identity or (address is not None and line.peer != address):
            self.foreign += 1
            self._note_stranger(message, sender, now)
            return
        if now - self.last_message > self.config.timeouts.heartbeat and self.origin is not None:
            self.origin.reset()  # it may have been rebooted, and must have no pose before its origin then
        self.last_message = now
        ordered = self.tracker.in_order(message.get_seq(), now)
        if ordered or kind in _UNORDERED:
            # A TIMESYNC that answers one of ours says nothing of the autopilot's own.
            if kind != "TIMESYNC" or message.tc1 == 0:
                self.rates.heard(kind)
            try:
                self._handle(kind, message, now)
            except (ValueError, ArithmeticError, struct.error):  # absurd figures in a message with a right checksum
                self.tracker.counters.invalid += 1

    def _note_stranger(self, message: Message, sender: tuple[int, int], now: float) -> None:
        if sender[0] == self.config.system_id:
            if message.get_type() == "HEARTBEAT" and (
                message.type == mavlink.MAV_TYPE_GCS or self.dialect is ARDUPILOT  # which heeds any with that id
            ):
                self.namesake = now
                words = f"another station uses doorman's system id {sender[0]}: the autopilot may miss that doorman has stopped"
                self.events.happen_at_most(RARELY, EventKind.FOREIGN, now, words, component=sender[1])
        elif self.identity is None or sender[0] != self.identity[0]:
            words = f"messages of system {sender[0]} are ignored"
            self.events.happen_at_most(RARELY, EventKind.FOREIGN, now, words, component=sender[1])

    def _meet(self, message: Message, sender: tuple[int, int], address: Address, line: Line, now: float) -> bool:
        """Take in a heartbeat; whether it is one of an autopilot that may be ours."""
        dialect = dialect_of(message.autopilot)
        if dialect is not None and self.identity not in (None, sender) and address == line.peer:
            self.peer.another(sender, self.identity, now)
        known = dialect is not None and message.type in MULTIROTORS and sender[1] == mavlink.MAV_COMP_ID_AUTOPILOT1
        if not known or self.config.vehicle_system not in (None, sender[0]):
            return False
        if self.identity is None:
            assert dialect is not None
            self.identity, self.vehicle_type = sender, int(message.type)
            self._set_up(dialect, now)
            words = f"{dialect.name}, system {sender[0]}"
            self.events.happen(EventKind.CONNECTED, now, words, dialect=dialect.name, system=sender[0])
        return True

    def _set_up(self, dialect: Dialect, now: float) -> None:
        """Make ready for what this autopilot needs."""
        config, self.dialect = self.config, dialect
        if config.mocap and config.origin is not None:
            self.origin = (CautiousOrigin if dialect is PX4 else Origin)(config.origin)
        if config.mocap and dialect.asks_time:  # a link in "normal" mode sends no requests by itself
            self.rates.want("TIMESYNC", config.rates.timesync)
        self._asks_estimator = dialect.says_what_is_valid and not config.mocap
        if self._asks_estimator:
            self.rates.want("ESTIMATOR_STATUS", _STATUS_RATE)
            self.tracker.expect_estimator(now)
        self.stream.angle_boost, self.stream.keeps_tilt = dialect.angle_boost, dialect.keeps_tilt

    def _handle(self, kind: str, message: Message, now: float) -> None:
        dialect = self.dialect
        assert dialect is not None
        if kind == "HEARTBEAT":
            self.tracker.heartbeat(message, dialect, now)
            sample = self.tracker.sample
            self.authority.heartbeat(sample.mode, sample.armed, sample.system_status, dialect, now)
        elif kind == "TIMESYNC":
            self._timesync(message, now)
        elif kind == "COMMAND_ACK":
            config = self.config
            if message.target_system in (0, config.system_id) and message.target_component in (0, config.component_id):
                self.exchange.post(message.command, message.result)
                if message.result == mavlink.MAV_RESULT_ACCEPTED:
                    self.authority.accepted(message.command, now)
        elif kind == "PARAM_VALUE":
            value = dialect.decode_parameter(message.param_value, message.param_type)
            self.exchange.post(message.param_id, value, message.param_type)
        elif kind == "STATUSTEXT":
            self._tell(self._texts.take(message, now))
        elif kind == "GPS_GLOBAL_ORIGIN":
            if self.origin is not None:
                self.origin.heard(now)
        elif kind == "ESTIMATOR_STATUS":
            if self.origin is not None:
                self.origin.estimator(message.flags)
            if self._asks_estimator:
                self.tracker.estimator(message.flags)
        else:
            self.tracker.take(message, now)

    def _timesync(self, message: Message, now: float) -> None:
        received = self.time.nanoseconds()
        if message.tc1 == 0:  # its own request: our time, so that it can map the stamps of our poses
            self._outgoing.append(mavlink.MAVLink_timesync_message(received, message.ts1))
            return
        result = self.clock.answer(message.ts1, message.tc1, received)
        if result is SyncResult.JUMPED:
            self.events.happen(EventKind.CLOCK_JUMPED, now, "the autopilot's clock jumped")
        elif result is SyncResult.REBOOTED:
            self.events.happen(EventKind.REBOOTED, now, "the autopilot's clock started anew")
            self.tracker.reset()
            if self._asks_estimator:
                self.tracker.expect_estimator(now)
            self.exchange.forget()
            self.rates.restart()
            if self.origin is not None:
                self.origin.reset()
            self.authority.rebooted(now)

    def _tell(self, texts: list[StatusText]) -> None:
        for one in texts:
            self.exchange.post_text(one)
            self.events.happen(EventKind.STATUS_TEXT, one.time, one.text, severity=one.severity)

    def _note_damage(self, now: float) -> None:
        assert self.codec is not None
        counters, telemetry = self.codec.counters, self.tracker.counters
        figures = (
            counters.corrupted + counters.malformed, telemetry.disordered, telemetry.invalid, counters.bad_signatures
        )  # fmt: skip
        kinds = (EventKind.CORRUPTED, EventKind.DISORDERED, EventKind.INVALID_DATA, EventKind.BAD_SIGNATURE)
        if figures != self._noted:
            for kind, figure, before in zip(kinds, figures, self._noted, strict=True):
                if figure != before:
                    self.events.happen_at_most(HEARTBEAT, kind, now, kind.value, count=figure)
            self._noted = figures


def wanted_rates(config: PixhawkConfig) -> dict[str, float]:
    """Rates of the telemetry that is requested [1/s], by name of the message."""
    return {
        "ATTITUDE_QUATERNION": config.rates.attitude, "LOCAL_POSITION_NED": config.rates.position, "ATTITUDE_TARGET": 20.0,
        "EXTENDED_SYS_STATE": _STATUS_RATE, "SYS_STATUS": _STATUS_RATE, "BATTERY_STATUS": 2.0,
    }  # fmt: skip
