"""An emulated Tracker with a receiver on it, and short ways to wait for what it tells."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from virtual_time import CLOCK

from doorman.cli.vehicles.rig_demo import free_port
from doorman.hardware.mocap import MocapConfig, MocapEvent, MocapFault, MocapReceiver, PoseQuality, PoseSample
from doorman.rig.emulators.mocap.emulator import BodyPose, MocapEmulator, TrackerSetup
from doorman.rig.emulators.mocap.faults import StreamFaults

NAME = "vehicle"


def swaying(at: float) -> BodyPose:
    """A vehicle that sways, gently enough for every limit."""
    half = 0.2 * math.sin(0.9 * at)
    return BodyPose(true_position(at), [math.cos(half), 0.0, 0.0, math.sin(half)])


def true_position(at: float) -> list[float]:
    return [0.4 * math.sin(at), 0.3 * math.cos(1.3 * at), 1.0 + 0.1 * math.sin(0.7 * at)]


def true_velocity(at: float) -> list[float]:
    return [0.4 * math.cos(at), -0.39 * math.sin(1.3 * at), 0.07 * math.cos(0.7 * at)]


def start_rig(
    source: Any = swaying, emulator: dict[str, Any] | None = None, faults: dict[str, Any] | None = None, **fields: Any
) -> Rig:
    """A running emulator and a receiver that is not open; `emulator` and `faults` are its, `fields` the receiver's."""
    port = free_port()
    # Loaded machines are slow: faults are told from delays of the test's own threads by wider times than in flight.
    given = {"stale_after": 0.06, "prediction_limit": 0.2, "max_delay": 0.05, "hold": 0.1} | fields
    config = MocapConfig(**{"object_name": NAME, "connection": f"udp:{port}"} | given)
    tracker = MocapEmulator(
        source, TrackerSetup(NAME, **{"rate": config.rate} | (emulator or {})), ("127.0.0.1", port), CLOCK
    )
    for name, value in (faults or {}).items():
        setattr(tracker.faults, name, value)
    tracker.open()
    return Rig(tracker, config)


class Rig:
    """An emulator that sends, and a receiver that may be opened."""

    def __init__(self, emulator: MocapEmulator, config: MocapConfig) -> None:
        self.emulator = emulator
        self.config = config
        self.receiver = MocapReceiver(config, CLOCK)
        self.seen: list[MocapEvent] = []

    def heal(self) -> None:
        """End every fault of the emulator."""
        self.emulator.stream.faults = StreamFaults()

    def settle(self) -> None:
        """Wait until all is well, and forget what has been."""
        self.until(lambda sample: sample.fresh and not sample.fault)
        self.receiver.events()
        self.seen.clear()

    def events(self) -> list[MocapEvent]:
        """Everything that has happened so far."""
        self.seen += self.receiver.events()
        return self.seen

    def has(self, fault: MocapFault, began: bool = True) -> MocapEvent | None:
        """Newest event of a fault."""
        return next((one for one in reversed(self.events()) if one.fault is fault and one.began == began), None)

    def until(self, condition: Callable[[PoseSample], Any], timeout: float = 5.0) -> PoseSample:
        """Wait until a sample meets a condition; looks whenever the thread has done something."""
        end = CLOCK.now() + timeout
        found: list[PoseSample] = []

        def look(pipeline: Any) -> bool:
            sample = self.receiver.read()
            if condition(sample):
                found.append(sample)
            return bool(found)

        while not found:
            assert CLOCK.now() < end, f"not within {timeout} s: {self.receiver.read()} {self.events()}"
            self.receiver._wait(look, 0.01)
        return found[0]

    def until_event(self, fault: MocapFault, began: bool = True, timeout: float = 5.0) -> MocapEvent:
        """Wait for an event."""
        self.until(lambda sample: self.has(fault, began), timeout)
        event = self.has(fault, began)
        assert event is not None
        return event

    def until_lost(self) -> PoseSample:
        """Wait until there is no pose, and see that it is marked as such."""
        lost = self.until(lambda sample: sample.quality is PoseQuality.LOST)
        assert not lost.fresh
        assert not lost.usable
        return lost

    def until_fresh(self, after: float = -math.inf, timeout: float = 5.0) -> PoseSample:
        """Wait for a fresh pose that was measured after a time, and see that it is true."""
        sample = self.until(lambda sample: sample.fresh and sample.time > after, timeout)
        self.assert_true(sample)
        return sample

    def assert_true(self, sample: PoseSample, tolerance: float = 0.012) -> None:
        """The pose is that of the time on its stamp; the stamp may err by some scheduling of the test's own threads."""
        assert np.linalg.norm(sample.position - true_position(sample.time)) < tolerance


def is_predicted(sample: PoseSample) -> bool:
    return sample.quality is PoseQuality.PREDICTED
