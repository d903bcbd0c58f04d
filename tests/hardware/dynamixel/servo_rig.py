"""An open bus on emulated servos, with short ways to command it and to look behind it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from virtual_time import CLOCK

from doorman.hardware.dynamixel import BusState, ServoBus, ServoConfig, ServoEvent, ServoFault, ServoSample
from doorman.hardware.dynamixel.registers import Unit
from doorman.rig.emulators.servos import ServoEmulator
from doorman.rig.emulators.servos.unit import EmulatedServo

SLOW = [0.2, 0.2, 0.2, 0.2]
LOWER, UPPER, FASTEST = [-np.pi, -1.65, -1.65, -1.80], [np.pi, 1.65, 1.65, 1.80], [3.1] * 4


class Rig:
    """Emulated servos with a bus on them."""

    def __init__(self, emulator: ServoEmulator, config: ServoConfig) -> None:
        self.emulator = emulator
        self.config = config
        self.bus = ServoBus(config, CLOCK)
        self.seen: list[ServoEvent] = []

    def servo(self, servo_id: int) -> EmulatedServo:
        return self.emulator.servo(servo_id)

    def trip(self, servo_id: int, bits: int) -> None:
        with self.emulator.lock:
            self.servo(servo_id).trip(bits)

    def rows(self, name: str) -> list[int]:
        return [self.row(servo_id, name) for servo_id in self.config.ids]

    def row(self, servo_id: int, name: str) -> int:
        with self.emulator.lock:
            return self.servo(servo_id).memory.get(name)

    def set_row(self, servo_id: int, name: str, value: int) -> None:
        with self.emulator.lock:
            self.servo(servo_id).memory.set(name, value)

    def true_angles(self) -> np.ndarray:
        with self.emulator.lock:
            return self.emulator.plant.motion(CLOCK.now()).angles

    def true_rates(self) -> np.ndarray:
        with self.emulator.lock:
            return self.emulator.plant.motion(CLOCK.now()).rates

    def events(self) -> list[ServoEvent]:
        """Everything that has happened so far."""
        self.seen += self.bus.events()
        return self.seen

    def began(self, fault: ServoFault, servo_id: int | None = None) -> list[ServoEvent]:
        return [
            e for e in self.events() if e.began and e.fault is fault and (servo_id is None or e.servo_id == servo_id)
        ]

    def until(self, condition: Callable[[ServoSample], bool], timeout: float = 2.0, rates: Any = None) -> ServoSample:
        """Command rates, or rates and a gripper's current, until a sample meets a condition."""
        end = CLOCK.now() + timeout
        sample = self.bus.read()
        while not condition(sample):
            assert CLOCK.now() < end, f"not within {timeout} s: {sample}"
            if rates is not None:
                self.command(rates)
            sample = self.bus.wait(sample, 1.0)
        return sample

    def command(self, goals: Any) -> None:
        """Rates, or a tuple of rates and a gripper's current."""
        self.bus.command(*(goals if isinstance(goals, tuple) else (goals,)))

    def fly(self, rates: Any, seconds: float) -> list[ServoSample]:
        """Command rates for some time."""
        samples, end = [self.bus.read()], CLOCK.now() + seconds
        while CLOCK.now() < end:
            self.command(rates)
            samples.append(self.bus.wait(samples[-1], 1.0))
        return samples


def follows(sample: ServoSample) -> bool:
    return sample.state is BusState.FOLLOWING


def holds(sample: ServoSample) -> bool:
    return sample.state is BusState.HOLDING


def has(fault: ServoFault) -> Callable[[ServoSample], bool]:
    return lambda sample: bool(sample.fault & fault)


def assert_stopped(rig: Rig) -> None:
    """The joints come to rest and stay there, whatever is commanded."""
    rig.fly(SLOW, 0.12)
    at_rest = rig.true_angles()
    rig.fly(SLOW, 0.06)
    assert rig.true_angles() == pytest.approx(at_rest, abs=2e-4)


def assert_moving(rig: Rig) -> None:
    rig.fly(SLOW, 0.12)
    assert rig.true_rates() == pytest.approx(SLOW, abs=2 * Unit.VELOCITY)


def stops_by(rig: Rig, fault: ServoFault) -> ServoSample:
    """The first sample that tells a fault holds the arm, and the arm stops."""
    sample = rig.until(has(fault), rates=SLOW)
    assert holds(sample) and not sample.goals.any()
    assert_stopped(rig)
    return sample


def goes_on(rig: Rig, recovered: bool = False) -> None:
    """The arm follows again, by itself or once it is recovered."""
    if recovered:
        assert holds(rig.fly(SLOW, 0.05)[-1]), "latched"
        assert rig.bus.recover() == ()
    rig.until(follows, rates=SLOW)
    assert_moving(rig)
