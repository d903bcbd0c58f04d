"""Poses of any `PoseSource` in place of a stream: whoever flies by a `MocapReceiver` flies by these."""

from __future__ import annotations

from doorman.clocks import BRIEFLY, Clock
from doorman.exceptions import BackendError
from doorman.hardware.mocap.config import MocapConfig
from doorman.hardware.mocap.faults import Figures, MocapEvent, MocapStatistics
from doorman.hardware.mocap.receiver import Judge, MocapReceiver
from doorman.hardware.mocap.sample import PoseSample, PoseSource


class PolledReceiver(MocapReceiver):
    """Asks a source, which says itself what is wrong with its poses."""

    def __init__(self, config: MocapConfig, source: PoseSource, clock: Clock, judge: Judge = lambda pose: pose) -> None:
        super().__init__(config, clock, judge=judge)  # rate, latency and limits; the connection is of no use
        self._source = source

    def open(self, timeout: float | None = None) -> None:
        self._figures, self._count, self._began = Figures(), -1, self._clock.now()
        self._source.open()
        end = self._clock.now() + (self.config.open_timeout if timeout is None else timeout)
        while not self.read().usable:
            if self._clock.now() > end:
                self._source.stop()
                raise BackendError("the source brings no pose", field="poses", allowed="a usable PoseSample")
            self._clock.sleep(BRIEFLY)

    def read(self) -> PoseSample:
        sample = self._source.read()
        if sample.count > self._count >= 0:
            self._figures.frame(self._clock.now(), max(sample.lateness - self.config.latency, 0.0), 0)
            self._figures.pose(0.0, sample.frame_number, sample.position.tolist())
        self._count = sample.count
        return self._judge(sample)

    def wait(self, sample: PoseSample, timeout: float) -> PoseSample:
        end = self._clock.now() + timeout
        while (newest := self.read()).count <= sample.count:
            if self._clock.now() > end:
                raise BackendError("no new pose", field="poses", given=f"after {timeout:g} s")
            self._clock.sleep(BRIEFLY)
        return newest

    def events(self) -> list[MocapEvent]:
        return []

    @property
    def statistics(self) -> MocapStatistics:
        elapsed = max(self._clock.now() - self._began, 1e-3)
        return self._figures.statistics({}, self._figures.frames / elapsed, self.config.latency)

    def stop(self) -> None:
        self._source.stop()
