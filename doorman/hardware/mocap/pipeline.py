"""Everything between datagrams and samples, without sockets, threads or a clock of its own."""

from __future__ import annotations

import math
from dataclasses import replace

from doorman.hardware.events import EventLog
from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.datagrams.stream import RATE_AT_OPEN, Sender, StreamReader
from doorman.hardware.mocap.faults import FaultBook, Figures, MocapEvent, MocapFault, MocapStatistics
from doorman.hardware.mocap.poses.sample import nothing_yet
from doorman.hardware.mocap.poses.tracker import PoseTracker


class Pipeline:
    def __init__(self, config: MocapConfig, log: EventLog[MocapEvent]) -> None:
        self._config = config
        self.book = FaultBook(log, config.hold)
        self._figures = Figures()
        self._stream = StreamReader(config, self.book, self._figures)
        self._tracker = PoseTracker(config, self.book, self._figures)
        self.latest = nothing_yet()  # newest measurement; replaced as a whole

    @property
    def ready(self) -> bool:
        return self.latest.count > 0 and self._stream.monitor.near(RATE_AT_OPEN) is True

    @property
    def wrong_rate(self) -> float | None:
        """The measured rate, if it is far from the configured one [1/s]."""
        return self._stream.frame_rate if self._stream.monitor.near(RATE_AT_OPEN) is False else None

    def feed(self, datagram: bytes, sender: Sender, arrival: float, raw: float) -> None:
        reading = self._stream.read(datagram, sender, arrival, raw)
        sample = None if reading is None else self._tracker.take(reading)
        if sample is not None:
            self.latest = replace(sample, fault=self.book.holds)

    def tick(self, now: float) -> None:
        self._stream.tick(now)
        if self.latest.count:
            age = now - self.latest.time
            limits = (
                (MocapFault.STALE, self._config.stale_after),
                (MocapFault.LOST, self._config.prediction_limit),
            )
            for fault, limit in limits:
                self.book.keep(fault, age > limit, now, f"no pose for {1e3 * limit:.0f} ms" if age > limit else "")
        self.book.tick(now)
        if self.latest.fault != self.book.holds:
            self.latest = replace(self.latest, fault=self.book.holds)

    def deadline(self, now: float) -> float:
        """When `tick` must be called next if nothing comes [s]; ∞ if there is nothing to wait for."""
        ages = (self._config.stale_after, self._config.prediction_limit) if self.latest.count else ()
        times = (*(self.latest.time + age for age in ages), self._stream.deadline, self.book.deadline)
        return min((time for time in times if time > now), default=math.inf)

    def diagnosis(self) -> str:
        return self._stream.diagnosis()

    def statistics(self) -> MocapStatistics:
        return self._figures.statistics(self.book.counts, self._stream.frame_rate, self._config.latency)
