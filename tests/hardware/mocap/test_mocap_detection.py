"""How soon faults are told and acted on, with the default configuration and a clock of the test's own: exact and repeatable.

The emulated Tracker's packets go straight into the pipeline behind the socket. What the thread and the network add is not in it.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from mocap_rig import NAME, swaying, true_position
from mocap_table import FAULTS, milliseconds

from doorman.background import EventLog
from doorman.hardware.mocap import MocapConfig, MocapFault, PoseQuality
from doorman.hardware.mocap.tracker import Pipeline
from doorman.rig.emulators.mocap.emulator import TrackerSetup, TrackerStream

STEP = 0.001
SENDER = ("127.0.0.1", 4000)
CONFIG = MocapConfig(NAME)


class Simulated:
    """Tracker and pipeline on a common clock."""

    def __init__(self) -> None:
        self.log = EventLog()
        self.pipeline = Pipeline(CONFIG, self.log)
        self.stream = TrackerStream(swaying, TrackerSetup(NAME, first_frame=500_000))
        self.now = 100.0
        self.slewed = 0.0
        """By which a time server has moved the monotonic clock [s]."""
        self.exposure = 100.0
        self.extra: Callable[[float], None] = lambda now: None
        self.checked = 0
        self.run(0.6, step=0.005)

    def run(self, seconds, until=lambda: False, step=STEP):
        """Let time pass; returns how much until a condition held."""
        start = self.now
        while self.now < start + seconds:
            if until():
                return self.now - start
            self.now += step
            while self.exposure <= self.now:
                self.stream.expose(self.exposure)
                self.exposure += 1.0 / self.stream.rate
            for datagram in self.stream.take(self.now):
                self.pipeline.feed(datagram, SENDER, self.now + self.slewed, self.now)
            self.extra(self.now)
            self.pipeline.tick(self.now + self.slewed)
            self.check()
        return math.inf

    def sample(self):
        return self.pipeline.at(self.now + self.slewed)

    def check(self):
        """Whatever is wrong: a pose that becomes fresh was true at the time of its stamp, or later."""
        if self.pipeline.latest.count == self.checked:
            return
        self.checked = self.pipeline.latest.count
        sample = self.sample()
        if sample.fresh and not any(self.stream.faults.jump):
            taken = self.now - sample.age
            times = [taken + share * sample.age for share in (-0.05, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0)]
            error = min(math.dist(sample.position, true_position(at)) for at in times)
            assert error < 0.0025, f"older than it says: {error:.4f} m"

    def told(self, fault):
        return lambda: bool(fault & self.pipeline.book.holds)


def set_fault(**fields):
    def switch(simulated):
        for name, value in fields.items():
            setattr(simulated.stream.faults, name, value)

    return switch


def set_stream(**fields):
    def switch(simulated):
        for name, value in fields.items():
            setattr(simulated.stream, name, value)

    return switch


def lose_one(simulated):
    simulated.stream.faults.loss = 1.0
    simulated.stream.expose(simulated.exposure)
    simulated.exposure += CONFIG.period
    simulated.stream.faults.loss = 0.0


def hold_one_back(simulated):
    simulated.stream.faults.reorder = 1.0
    simulated.stream.expose(simulated.exposure)
    simulated.exposure += CONFIG.period
    simulated.stream.faults.reorder = 0.0


def send_damaged(simulated):
    simulated.extra = lambda now: simulated.pipeline.feed(b"\1" * 80, SENDER, now, now)


def send_foreign(simulated):
    simulated.extra = lambda now: simulated.pipeline.feed(b"\1" * 80, ("10.0.0.9", 1), now, now)


CASES = {
    **{row: (set_fault(**switch), fault) for row, (switch, fault, *_) in FAULTS.items()},
    "packets lost": (lose_one, MocapFault.DROPPED),
    "packets reordered": (hold_one_back, MocapFault.REORDERED),
    "damaged packets, noise": (send_damaged, MocapFault.CORRUPT),
    "single outliers": (set_fault(outliers=1.0), MocapFault.OUTLIER),
    "a stray frame number": (set_fault(number_offset=100_000), MocapFault.NUMBERING),
    "short gap": (set_fault(silent=True), MocapFault.STALE),
    "lasting jump: markers moved, or Tracker follows another body": (
        set_fault(jump=(0.0, 3.0, 0.0)),
        MocapFault.JUMPED,
    ),
    "lasting delay": (set_fault(delay=0.2), MocapFault.STALE),
    "frame numbers restart, ahead": (set_stream(frame_number=1_000_000), MocapFault.RESTARTED),
    "frame numbers restart, behind": (set_stream(frame_number=7), MocapFault.RESTARTED),
    "the rate changes by more than 2 %": (set_stream(rate=80.0), MocapFault.RATE),
    "another sender, or one that the sender itself refuses": (send_foreign, MocapFault.FOREIGN),
}


@pytest.mark.parametrize("row", CASES)
def test_a_fault_is_told_within_the_time_of_the_table(row):
    switch, fault = CASES[row]
    simulated = Simulated()
    assert simulated.sample().fresh
    switch(simulated)
    taken = simulated.run(3.0, simulated.told(fault))
    assert taken <= milliseconds(row) / 1e3 + STEP


@pytest.mark.parametrize(
    "switch",
    [
        set_fault(silent=True), set_fault(frozen=True), set_fault(zeroed=True), set_fault(absent=True),
        set_fault(not_finite=True), set_fault(stuck_number=True), set_fault(jump=(1.0, 0.0, 0.0)),
        set_fault(delay=0.5), set_fault(loss=1.0), set_fault(wrong_name="wand"), set_stream(frame_number=9),
    ],
)  # fmt: skip
def test_a_lasting_fault_ends_predictions_after_their_limit(switch):
    """Counted from the last pose: at most a period and the latency before the fault."""
    simulated = Simulated()
    switch(simulated)
    stale = simulated.run(1.0, lambda: simulated.sample().quality is PoseQuality.PREDICTED)
    lost = simulated.run(1.0, lambda: simulated.sample().quality is PoseQuality.LOST)
    slack = STEP + CONFIG.period + CONFIG.latency
    assert CONFIG.stale_after - slack <= stale <= CONFIG.stale_after + slack
    assert stale + lost <= CONFIG.prediction_limit + slack


@pytest.mark.parametrize(
    "switch",
    [set_fault(silent=True), set_fault(frozen=True), set_fault(absent=True), set_fault(not_finite=True),
     set_fault(jump=(1.0, 0.0, 0.0)), set_fault(wrong_name="wand")],
)  # fmt: skip
def test_poses_are_back_soon_after_the_fault(switch):
    simulated = Simulated()
    switch(simulated)
    simulated.run(0.5)
    simulated.stream.faults = type(simulated.stream.faults)()
    back = simulated.run(1.0, lambda: simulated.sample().fresh)
    assert back <= CONFIG.acquire_frames * CONFIG.period + CONFIG.latency + CONFIG.prediction_limit + 2 * STEP


@pytest.mark.parametrize("delay", [0.04, 0.2, 1.0])
def test_a_delay_that_lasts_stays_stale(delay):
    simulated = Simulated()
    simulated.stream.faults.delay = delay
    simulated.run(0.05 + delay)
    assert simulated.run(15.0, lambda: simulated.sample().fresh, step=0.01) == math.inf
    simulated.stream.faults.delay = 0.0
    simulated.run(delay + 0.2)
    assert simulated.sample().fresh


@pytest.mark.parametrize(
    ("growth", "within"), [pytest.param(0.5e-3, 45.0, marks=pytest.mark.slow), (1.0e-3, 22.0), (1.9e-3, 12.0)]
)
def test_delay_that_grows_slowly(growth, within):
    simulated = Simulated()
    simulated.run(25.0, step=0.005)
    start = simulated.now
    simulated.extra = lambda now: set_fault(delay=growth * (now - start))(simulated)
    assert simulated.run(60.0, simulated.told(MocapFault.DELAYED), step=0.005) <= within
    assert simulated.stream.faults.delay < 0.024
    simulated.run(0.008 / growth, step=0.005)
    assert simulated.run(10.0, lambda: simulated.sample().fresh, step=0.005) == math.inf


@pytest.mark.parametrize(
    ("slew", "seconds"),
    [(500e-6, 20.0), (-500e-6, 20.0), (0.08, 20.0),
     *(pytest.param(slew, 100.0, marks=pytest.mark.slow) for slew in (500e-6, -500e-6))],
)  # fmt: skip
def test_a_time_server_that_slews_the_clock_is_no_delay(slew, seconds):
    simulated = Simulated()
    simulated.run(25.0, step=0.005)
    start = simulated.now
    simulated.extra = lambda now: setattr(simulated, "slewed", slew * (now - start))
    assert simulated.run(seconds, lambda: bool(simulated.pipeline.book.holds), step=0.004) == math.inf
    assert simulated.sample().fresh
    assert simulated.sample().age < CONFIG.latency + CONFIG.period + 0.006


@pytest.mark.parametrize("rate", [80.0, 130.0])
def test_a_wrong_rate_is_not_fresh(rate):
    simulated = Simulated()
    simulated.stream.rate = rate
    simulated.run(1.5)
    assert simulated.run(5.0, lambda: simulated.sample().fresh, step=0.004) == math.inf


def test_a_rate_as_of_television_is_followed():
    """119.88 frames a second, where 120 were told."""
    simulated = Simulated()
    simulated.stream.rate = 100.0 / 1.001
    simulated.run(12.0)
    assert simulated.sample().fresh
    assert not simulated.pipeline.book.holds
    assert simulated.pipeline.statistics().frame_rate == pytest.approx(99.9, abs=0.02)


def test_deadlines_are_those_of_the_next_change():
    simulated = Simulated()
    simulated.stream.faults.silent = True
    simulated.run(0.02)
    names = []
    while math.isfinite(due := simulated.pipeline.deadline(simulated.now)):
        before = simulated.pipeline.book.holds
        simulated.run(due - simulated.now - 2 * STEP)
        assert simulated.pipeline.book.holds == before
        simulated.run(3 * STEP)
        names.append(simulated.pipeline.book.holds & ~before)
    assert names[:3] == [MocapFault.STALE, MocapFault.LOST, MocapFault.SILENT]
