"""From datagrams to new measurements of the object, with everything that can be wrong on the way."""

from __future__ import annotations

import math
from typing import NamedTuple

from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.faults import FaultBook, Figures, MocapFault
from doorman.hardware.mocap.frames import MILLIMETRES
from doorman.hardware.mocap.packets import TrackedObject, Vector, parse
from doorman.hardware.mocap.sequence import GROSS, FrameClock, FrameSequence, Order, RateMonitor

FARTHEST = 1000 * MILLIMETRES
"""No object is farther away from Vicon's origin [mm]."""
LARGEST_ANGLE = 2 * math.tau
"""[rad]."""
OCCLUDED_REPEATS = 2
"""Repetitions of a pose that are reported; none is ever used."""
RATE_AT_OPEN = 5 * GROSS
"""Deviation of the rate that `open` refuses; finer figures take longer than it waits."""
_NAMES_KEPT = 20
_POSES_KEPT = 1000
"""Poses that are known again: noise makes every true one new to the last bit."""

Sender = tuple[str, int]


class Reading(NamedTuple):
    """A measurement of the object that has not been seen before."""

    frame: int  # number of its frame, without wraps
    frame_number: int  # its number modulo 2³², as the cameras send it
    arrival: float  # by `time.monotonic` [s]
    time: float  # when it was true, by the same clock [s]
    translation: Vector  # [mm]
    rotation: Vector  # [rad]
    era: int  # counts how often the frame numbers began anew


class StreamReader:
    def __init__(self, config: MocapConfig, book: FaultBook, figures: Figures) -> None:
        self._config, self._book, self._figures = config, book, figures
        self._clock = FrameClock(config.rate, config.latency)
        self._sequence = FrameSequence(self._clock, config.rate)
        self._sender: Sender | None = None
        self._seen = True
        self._absent = self._repeats = self._era = 0
        self._poses: dict[tuple[Vector, Vector], None] = {}
        self.names: dict[str, None] = {}  # objects that were in the stream
        self.monitor = RateMonitor(config.rate)
        self.last_packet: float | None = None  # when the newest packet came [s]

    @property
    def frame_rate(self) -> float:
        """Measured frame rate; the nominal one until it is measured [1/s]."""
        return self._config.rate * (1.0 - self.monitor.deviation)

    def read(self, datagram: bytes, sender: Sender, arrival: float, raw: float) -> Reading | None:
        self._figures.packets += 1
        if not self._welcome(sender):
            self._book.strike(MocapFault.FOREIGN, arrival, f"packets from {sender[0]}:{sender[1]}")
            return None
        packet = parse(datagram)
        if isinstance(packet, str):
            self._book.strike(MocapFault.CORRUPT, arrival, packet)
            return None
        found = [one for one in packet.objects if one.name == self._config.object_name]
        if len(found) > 1:
            self._book.strike(MocapFault.CORRUPT, arrival, f"{len(found)} objects of the same name in a packet")
            return None
        for fault in packet.refused:
            self._book.strike(fault, arrival, "refused by the sender of this stream")
        if found and self._sender is None:
            self._sender = sender
        self.last_packet = arrival
        self._book.keep(MocapFault.SILENT, False, arrival)
        for one in packet.objects:
            if len(self.names) < _NAMES_KEPT or one.name == self._config.object_name:
                self.names[one.name] = None
        new = bool(found) and self._unseen(found[0])
        if not self._in_order(packet.frame_number, arrival, raw, bool(found)) or not found:
            return None
        return self._measurement(found[0], new, packet.frame_number, arrival, raw)

    def tick(self, now: float) -> None:
        """Look whether the stream has fallen silent; then anybody may send."""
        if self.last_packet is None or now - self.last_packet < self._config.silent_after:
            return
        self._sender = None
        self._book.keep(MocapFault.SILENT, True, now, f"no packet for {self._config.silent_after:g} s")

    @property
    def deadline(self) -> float:
        """When silence begins if nothing comes [s]; ∞ if it has."""
        if self.last_packet is None or MocapFault.SILENT in self._book.holds:
            return math.inf
        return self.last_packet + self._config.silent_after

    def diagnosis(self) -> str:
        holds = self._book.holds
        if self.last_packet is None or MocapFault.SILENT in holds:
            if MocapFault.FOREIGN in holds:
                return "only packets from other senders arrive"
            return "only damaged packets arrive" if MocapFault.CORRUPT in holds else "no packets arrive"
        if self._config.object_name not in self.names:
            return f"the stream holds only: {', '.join(sorted(self.names)) or 'no object'}"
        if MocapFault.OCCLUDED in holds:
            return "the cameras do not see the object"
        names = ", ".join(str(fault.name).lower() for fault in holds)
        return f"no steady poses arrive ({names or 'too few yet'})"

    def _welcome(self, sender: Sender) -> bool:
        if self._config.sender is not None and sender[0] != self._config.sender:
            return False
        return self._sender is None or sender == self._sender

    def _unseen(self, found: TrackedObject) -> bool:
        """Whether a pose has not been on the wire before, in order or not."""
        pose = (found.translation, found.rotation)
        if pose in self._poses or not any((*found.translation, *found.rotation)):
            return False
        self._poses[pose] = None
        if len(self._poses) > _POSES_KEPT:
            del self._poses[next(iter(self._poses))]
        return True

    def _in_order(self, number: int, arrival: float, raw: float, found: bool) -> bool:
        """Whether a packet belongs to the newest frame and brings something that is not known."""
        order = self._sequence.classify(number, raw)
        if order in (Order.NEXT, Order.RESTARTED):
            self._begin_frame(arrival, raw, order is Order.RESTARTED)
        if order is Order.REPEATED or (order is Order.SAME and found and self._seen):
            self._book.strike(MocapFault.DUPLICATED, arrival, f"frame {number} twice")
            return False
        if order in (Order.STRANGE, Order.LATE):
            fault = MocapFault.NUMBERING if order is Order.STRANGE else MocapFault.REORDERED
            self._book.strike(fault, arrival, f"frame {number} after {self._sequence.newest}")
            return False
        self._seen = self._seen or found
        return True

    def _begin_frame(self, arrival: float, raw: float, restarted: bool) -> None:
        """A frame ends and a newer one begins: count what was missing, and look at the time."""
        self._absent = 0 if self._seen else self._absent + 1
        if self._absent >= self._config.missing_frames:
            others = ", ".join(sorted(self.names.keys() - {self._config.object_name}))
            self._book.keep(MocapFault.MISSING, True, arrival, f"the stream holds {others or 'no object'}")
        self._seen = False
        frame, skipped = self._sequence.newest or 0, self._sequence.skipped
        if restarted:
            self._era += 1
            self.monitor = RateMonitor(self._config.rate)
            self._book.strike(MocapFault.RESTARTED, arrival, f"frame numbers began anew at {frame}")
        if skipped:
            self._book.strike(MocapFault.DROPPED, arrival, f"{skipped} frames missing before {frame}")
        delay = self._clock.observe(frame, raw)
        self._figures.frame(arrival, delay, skipped)
        if delay > self._config.max_delay:
            self._book.strike(MocapFault.DELAYED, arrival, f"frame {frame} is {1e3 * delay:.0f} ms late")
        if self.monitor.observe(frame, raw):
            wrong = self.monitor.wrong
            text = f"{self.frame_rate:.2f} frames a second instead of {self._config.rate:g}" if wrong else ""
            self._book.keep(MocapFault.RATE, wrong, arrival, text)
            if self.monitor.learnt is not None:
                self._clock.follow(self.monitor.learnt)

    def _measurement(self, found: TrackedObject, new: bool, number: int, arrival: float, raw: float) -> Reading | None:
        """The object's pose, unless it is impossible or old."""
        self._absent = 0
        self._book.keep(MocapFault.MISSING, False, arrival)
        values = (*found.translation, *found.rotation)
        if not all(math.isfinite(value) for value in values) or (
            max(map(abs, found.translation)) > FARTHEST or max(map(abs, found.rotation)) > LARGEST_ANGLE
        ):
            self._book.strike(MocapFault.CORRUPT, arrival, f"impossible pose {values}")
            return None
        if not new:
            self._repeats += 1
            if self._repeats >= OCCLUDED_REPEATS:
                self._book.keep(MocapFault.OCCLUDED, True, arrival, "the pose repeats")
            return None
        self._repeats = 0
        self._book.keep(MocapFault.OCCLUDED, False, arrival)
        if MocapFault.RATE in self._book.holds:
            return None
        frame = self._sequence.newest or 0
        age = raw - self._clock.time_of(frame, raw)
        return Reading(frame, number, arrival, arrival - age, found.translation, found.rotation, self._era)
