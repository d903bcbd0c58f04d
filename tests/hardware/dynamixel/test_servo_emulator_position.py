"""Emulated servos in the modes that turn to a position, as the e-manual says and as ROBOTIS's own examples use them."""

from __future__ import annotations

import numpy as np
import pytest
from virtual_time import CLOCK

from doorman.rig.emulators.servos.bus import ServoBusLogic
from doorman.rig.emulators.servos.faults import BusFaults
from doorman.rig.emulators.servos.plant import LaggingJoints
from doorman.rig.emulators.servos.table import RATE_UNIT
from doorman.rig.emulators.servos.unit import EmulatedServo, ServoSetup

RANGE, LIMIT = 4, 6
MODE, TORQUE, PROFILE_VELOCITY, GOAL_POSITION, POSITION = 11, 64, 112, 116, 132
TICK = 2 * np.pi / 4096


class Bench:
    """One servo on a clock of its own."""

    def __init__(self, eeprom, angle=0.0, **mounting):
        self.servo = EmulatedServo(ServoSetup(1, eeprom, **mounting))
        self.plant = LaggingJoints([angle])
        self.bus = ServoBusLogic([self.servo], self.plant, BusFaults(), None)
        self.time = 0.0
        self.run(0.01)

    def run(self, seconds):
        """Largest rate of the joint meanwhile [rad/s]."""
        rates = []
        for _ in range(round(seconds / 0.005)):
            self.time += 0.005
            self.bus.tick(self.time)
            rates.append(abs(self.plant.motion(self.time).rates[0]))
        return max(rates)

    def write(self, address, size, value):
        return self.servo.write(address, value.to_bytes(size, "little", signed=value < 0))

    @property
    def angle(self):
        return self.plant.motion(self.time).angles[0]

    def __getitem__(self, name):
        return self.servo.memory.get(name)


@pytest.mark.parametrize("mode", [3, 4, 5])
def test_it_turns_to_its_goal_position(connect, mode):
    """The SDK's example `read_write`: torque, goal, and polling until it is there."""
    emulator, client = connect()
    assert client.write(MODE, 1, mode) == 0
    assert client.write(TORQUE, 1, 1) == 0
    assert client.read(GOAL_POSITION, 4) == client.read(POSITION, 4) == 2048
    assert client.write(GOAL_POSITION, 4, 2500) == 0
    end = CLOCK.now() + 10.0
    while abs(client.read(POSITION, 4) - 2500) > 1:
        assert CLOCK.now() < end
        CLOCK.sleep(0.02)
    assert emulator.plant.motion(CLOCK.now()).angles[0] == pytest.approx(452 * TICK, abs=3 * TICK)


@pytest.mark.parametrize("mode", [3, 4, 5])
@pytest.mark.parametrize(("drive_mode", "direction"), [(0, 1), (0, -1), (1, 1), (1, -1)])
def test_it_arrives_however_it_is_mounted_and_counts(mode, drive_mode, direction):
    eeprom = {"operating mode": mode, "drive mode": drive_mode, "homing offset": 100}
    bench = Bench(eeprom, 0.3, zero=1500, direction=direction)
    assert 100 <= bench["present position"] < 4196
    bench.write(TORQUE, 1, 1)
    before, start = bench.angle, bench["present position"]
    bench.run(0.5)
    assert bench.angle == before, "torque alone moves nothing"
    assert bench.write(GOAL_POSITION, 4, start + 300) == 0
    bench.run(2.0)
    assert bench["present position"] == start + 300
    assert bench.angle - before == pytest.approx(direction * (-1) ** drive_mode * 300 * TICK, abs=2 * TICK)
    assert bench["moving"] == 0


def test_goals_outside_the_limits_are_refused_in_position_mode_alone():
    limits = {"min position limit": 1000, "max position limit": 3000}
    bench = Bench(limits)
    goals = (999, 1000, 3000, 3001, -1)
    assert [bench.write(GOAL_POSITION, 4, goal) for goal in goals] == [LIMIT, 0, 0, LIMIT, LIMIT]
    assert bench.write(GOAL_POSITION, 4, 1_048_576) == RANGE
    assert bench["goal position"] == 3000
    for mode in (4, 5):
        assert [Bench(limits | {"operating mode": mode}).write(GOAL_POSITION, 4, goal) for goal in goals] == [0] * 5


@pytest.mark.parametrize(
    ("drive_mode", "velocity_limit", "profile", "fastest"),
    [(0, 130, 0, 130), (0, 130, 40, 40), (0, 60, 200, 60), (4, 60, 20, 60)],
)
def test_profile_and_velocity_limit_bound_its_rate(drive_mode, velocity_limit, profile, fastest):
    bench = Bench({"operating mode": 4, "velocity limit": velocity_limit, "drive mode": drive_mode})
    bench.write(PROFILE_VELOCITY, 4, profile)
    bench.write(TORQUE, 1, 1)
    for goal in (10_000, -10_000):
        bench.write(GOAL_POSITION, 4, goal)
        assert bench.run(1.0) == pytest.approx(fastest * RATE_UNIT, rel=1e-3)


def test_it_does_not_overshoot():
    bench = Bench({"velocity limit": 1023})
    bench.write(TORQUE, 1, 1)
    bench.write(GOAL_POSITION, 4, 3000)
    positions = []
    for _ in range(300):
        bench.run(0.01)
        positions.append(bench["present position"])
    assert max(positions) == positions[-1] == 3000


def test_torque_in_position_mode_begins_within_one_turn():
    bench = Bench({"operating mode": 4, "homing offset": 7})
    bench.write(TORQUE, 1, 1)
    bench.write(GOAL_POSITION, 4, 9000)
    bench.run(8.0)
    bench.write(TORQUE, 1, 0)
    assert bench["present position"] == 9000
    bench.write(MODE, 1, 3)
    assert bench["present position"] == 7 + (9000 - 7) % 4096
    bench.run(0.1)
    assert bench["present position"] == 7 + (9000 - 7) % 4096, "it goes on counting from there"
    bench.write(TORQUE, 1, 1)
    at_rest = bench.angle
    assert bench["goal position"] == bench["present position"]
    bench.run(0.5)
    assert bench.angle == at_rest


def test_torque_from_start_up_stays_where_it_is():
    bench = Bench({"operating mode": 4, "startup configuration": 1}, 0.5)
    assert bench["torque enable"] == 1
    assert bench.run(0.5) == 0.0
    bench.servo.reboot(bench.time)
    bench.run(0.5)
    assert bench.angle == 0.5


def test_the_bus_watchdog_stops_it_on_its_way():
    bench = Bench({})
    bench.write(TORQUE, 1, 1)
    bench.servo.hear(bench.time)
    bench.write(98, 1, 5)
    bench.write(GOAL_POSITION, 4, 4000)
    bench.run(0.5)
    stopped = bench.angle
    assert 0.1 < stopped < 1900 * TICK
    bench.run(0.5)
    assert bench.angle == pytest.approx(stopped, abs=1e-6)
    assert bench.write(GOAL_POSITION, 4, 2048) == RANGE


def test_current_based_position_mode_keeps_its_bound_of_the_current(connect):
    _, client = connect([ServoSetup(1, {"baud rate": 3, "operating mode": 5})])
    client.write(102, 2, 200)
    client.write(TORQUE, 1, 1)
    assert client.read(102, 2) == 200


def test_pwm_mode_stays_at_rest():
    bench = Bench({"operating mode": 16})
    bench.write(TORQUE, 1, 1)
    bench.write(100, 2, 500)
    assert bench.run(0.5) == 0.0


def test_modes_that_do_not_exist_are_refused(client):
    accepted = [mode for mode in range(18) if client.write(MODE, 1, mode) == 0]
    assert accepted == [0, 1, 3, 4, 5, 16]
    assert client.write(MODE, 1, 2) == RANGE
