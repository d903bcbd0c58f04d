"""Emulated servos: motion, protection and wire, asked with dynamixel-sdk, as the e-manual says."""

from __future__ import annotations

import os

import dynamixel_sdk as sdk
import numpy as np
import pytest
from servo_client import exchange
from virtual_time import CLOCK

from doorman.exceptions import BackendError
from doorman.rig.emulators.servos import ServoEmulator
from doorman.rig.emulators.servos.bus import BusFaults, LaggingJoints, ServoBusLogic
from doorman.rig.emulators.servos.packets import BROADCAST, Instruction
from doorman.rig.emulators.servos.table import RATE_UNIT
from doorman.rig.emulators.servos.unit import ENCODER, OVERHEATING, OVERLOAD, READY, EmulatedServo, ServoSetup

ACCESS, RANGE, LIMIT, LENGTH = 7, 4, 6, 5
TORQUE, GOAL_VELOCITY, WATCHDOG, VELOCITY, POSITION = 64, 104, 98, 128, 132
XM430 = {"model number": 1030, "firmware version": 38}


# ---------------------------------------------------------------- motion


def test_goal_velocity_moves_the_joint(connect):
    emulator, client = connect()
    client.write(TORQUE, 1, 1)
    client.write(GOAL_VELOCITY, 4, 100)
    CLOCK.sleep(0.3)
    assert client.read(VELOCITY, 4) == 100
    assert emulator.plant.motion(CLOCK.now()).rates[0] == pytest.approx(100 * RATE_UNIT, rel=1e-4)
    client.write(GOAL_VELOCITY, 4, 0)
    CLOCK.sleep(0.3)
    angle = emulator.plant.motion(CLOCK.now()).angles[0]
    assert angle > 0.5
    assert client.read(POSITION, 4) == 2048 + round(angle * 4096 / (2 * np.pi))


def test_torque_and_mode_decide_whether_it_moves(connect):
    emulator, client = connect()
    client.write(GOAL_VELOCITY, 4, 100)
    CLOCK.sleep(0.05)
    assert emulator.plant.motion(CLOCK.now()).rates[0] == 0.0
    client.write(11, 1, 3)
    client.write(TORQUE, 1, 1)
    client.write(GOAL_VELOCITY, 4, 100)
    CLOCK.sleep(0.05)
    assert emulator.plant.motion(CLOCK.now()).rates[0] == 0.0


def test_modes_that_do_not_exist_are_refused(client):
    assert [mode for mode in range(18) if client.write(11, 1, mode) == 0] == [0, 1, 3, 4, 5, 16]


def test_torque_on_begins_at_zero_velocity(client):
    client.write(GOAL_VELOCITY, 4, 100)
    client.write(TORQUE, 1, 1)
    assert client.read(GOAL_VELOCITY, 4) == 0


def test_mounting_homing_offset_and_reverse_mode(connect):
    setup = ServoSetup(1, READY | {"homing offset": 100}, zero=1000, direction=-1)
    emulator, client = connect([setup], angles=[0.5])
    ticks = round(0.5 * 4096 / (2 * np.pi))
    CLOCK.sleep(0.03)
    assert client.read(POSITION, 4) == 1000 - ticks + 100
    client.write(TORQUE, 1, 1)
    client.write(GOAL_VELOCITY, 4, -50)
    CLOCK.sleep(0.2)
    assert emulator.plant.motion(CLOCK.now()).rates[0] > 1.0
    client.write(TORQUE, 1, 0)
    client.write(10, 1, 1)
    client.write(TORQUE, 1, 1)
    client.write(GOAL_VELOCITY, 4, -50)
    CLOCK.sleep(0.2)
    assert emulator.plant.motion(CLOCK.now()).rates[0] < -1.0
    assert client.read(VELOCITY, 4) == pytest.approx(-50, abs=1)


# ---------------------------------------------------------------- protection


def test_bus_watchdog_of_the_manual(connect):
    """The manual's example, step by step."""
    emulator, client = connect()
    client.write(TORQUE, 1, 1)
    client.write(GOAL_VELOCITY, 4, 50)
    client.write(WATCHDOG, 1, 15)
    for _ in range(8):
        CLOCK.sleep(0.05)
        assert client.read(WATCHDOG, 1) == 15, "it fired though packets came"
    CLOCK.sleep(0.45)
    assert client.read(WATCHDOG, 1) == -1
    assert abs(emulator.plant.motion(CLOCK.now()).rates[0]) < 0.01
    assert client.write(GOAL_VELOCITY, 4, 100) == RANGE
    assert client.write(WATCHDOG, 1, 15) == RANGE
    assert client.write(WATCHDOG, 1, 0) == 0
    assert client.write(GOAL_VELOCITY, 4, 100) == 0
    assert client.read(TORQUE, 1) == 1


def test_bus_watchdog_fires_after_its_time():
    servo = EmulatedServo(ServoSetup(1))
    for name, value in (("torque enable", 1), ("goal velocity", 50), ("bus watchdog", 5)):
        servo.memory.set(name, value)
    servo.hear(10.0)
    servo.sense(10.099, 0.0, 0.0, 0.0)
    assert servo.memory.get("bus watchdog") == 5
    servo.sense(10.101, 0.0, 0.0, 0.0)
    assert servo.memory.get("bus watchdog") == 0xFF
    assert servo.goal_rate(10.101) == 0.0
    servo.memory.set("bus watchdog", 0)
    assert servo.goal_rate(10.101) > 0.0, "nobody has told it to stop"


def test_watchdog_sleeps_while_torque_is_off(client):
    client.write(WATCHDOG, 1, 2)
    CLOCK.sleep(0.15)
    assert client.read(WATCHDOG, 1) == 2


def test_overload_takes_the_torque_until_a_reboot(connect):
    emulator, client = connect()
    client.write(TORQUE, 1, 1)
    with emulator.lock:
        emulator.servo(1).trip(OVERLOAD)
    _, result, error = client.packets.read1ByteTxRx(client.port, 1, TORQUE)
    assert (result, error) == (sdk.COMM_SUCCESS, 0x80), "alert bit"
    assert client.read(TORQUE, 1) == 0
    assert client.read(70, 1) == OVERLOAD
    assert client.write(TORQUE, 1, 1) == 0x81
    assert client.read(TORQUE, 1) == 0
    client.write(168, 2, 65)
    assert client.packets.reboot(client.port, 1) == (sdk.COMM_SUCCESS, 0x80)
    assert client.packets.ping(client.port, 1)[1] == sdk.COMM_RX_TIMEOUT
    CLOCK.sleep(0.15)
    assert client.read(70, 1) == 0
    assert client.read(168, 2) == 224, "RAM is forgotten"
    assert client.write(TORQUE, 1, 1) == 0


def test_without_its_encoder_it_turns_and_does_not_see_it(connect):
    emulator, client = connect()
    client.write(TORQUE, 1, 1)
    with emulator.lock:
        emulator.servo(1).trip(ENCODER)
    before = client.read(POSITION, 4)
    CLOCK.sleep(0.3)
    assert emulator.plant.motion(CLOCK.now()).angles[0] > 0.01
    assert (client.read(POSITION, 4), client.read(VELOCITY, 4)) == (before, 0)


def test_it_answers_on_for_a_while_before_it_reboots():
    servo = EmulatedServo(ServoSetup(1, reboot_delay=0.5))
    servo.memory.set("led", 1)
    assert servo.execute(10.0, Instruction(1, 0x08, b"", True)) == (0, b"")
    servo.sense(10.4, 0.0, 0.0, 0.0)
    assert servo.is_up(10.4) and servo.memory.get("led") == 1
    servo.sense(10.5, 0.0, 0.0, 0.0)
    assert not servo.is_up(10.5) and servo.memory.get("led") == 0
    assert servo.is_up(10.61)


def test_heat_comes_back_after_a_reboot(connect):
    emulator, client = connect()
    with emulator.lock:
        emulator.servo(1).memory.set("present temperature", 85)
    CLOCK.sleep(0.03)
    assert client.read(70, 1) == OVERHEATING
    client.packets.reboot(client.port, 1)
    CLOCK.sleep(0.15)
    assert client.read(70, 1) == OVERHEATING


def test_reboot_brings_the_position_into_one_turn(connect):
    emulator, client = connect([1], angles=[2 * np.pi + 0.3])
    client.packets.reboot(client.port, 1)
    CLOCK.sleep(0.15)
    assert 0 <= client.read(POSITION, 4) < 4096


def test_clock_counts_milliseconds_and_starts_again():
    servo = EmulatedServo(ServoSetup(1))
    servo.reboot(100.0)
    readings = []
    for time_since in (0.1005, 0.1239, 32.7675, 32.7685, 40.0005):
        servo.sense(100.0 + time_since, 0.0, 0.0, 0.0)
        readings.append(servo.memory.get("realtime tick"))
    assert readings == [100, 123, 32767, 0, 7232]


# ---------------------------------------------------------------- wire


def test_return_delay_and_baud_rate_take_their_time():
    servos = [EmulatedServo(ServoSetup(servo_id, {"return delay time": 254})) for servo_id in (1, 2)]
    faults = BusFaults()
    read = Instruction(BROADCAST, 0x82, bytes.fromhex("84 00 04 00 01 02"), True)
    quick = ServoBusLogic(servos, LaggingJoints([0.0, 0.0]), faults, None)
    assert [due for due, _ in quick.respond(5.0, read)] == pytest.approx([5.0 + 508e-6, 5.0 + 2 * 508e-6])
    wired = ServoBusLogic(servos, LaggingJoints([0.0, 0.0]), faults, 1_000_000)
    instruction, status = 16 * 10e-6, 15 * 10e-6
    first = 5.0 + instruction + 508e-6 + status
    assert [due for due, _ in wired.respond(5.0, read)] == pytest.approx([first, first + 508e-6 + status])
    faults.delay = 0.01
    assert quick.respond(5.0, read)[0][0] == pytest.approx(5.0 + 508e-6 + 0.01)


def test_a_silent_servo_silences_those_after_it(connect):
    emulator, client = connect()

    def answers() -> list[int]:
        CLOCK.sleep(0.02)
        reads = sdk.GroupSyncRead(client.port, client.packets, POSITION, 4)
        for servo_id in (1, 2, 3, 4):
            reads.addParam(servo_id)
        reads.txRxPacket()
        return [servo_id for servo_id in (1, 2, 3, 4) if len(reads.data_dict[servo_id]) == 4]

    assert answers() == [1, 2, 3, 4]
    emulator.faults.silent.add(3)
    assert answers() == [1, 2]


def test_unplugged_port_is_gone_and_comes_back_at_its_link(make_emulator, tmp_path):
    emulator = make_emulator([1], link=tmp_path / "servos")
    descriptor = os.open(emulator.port, os.O_RDWR | os.O_NOCTTY)
    emulator.unplug()
    with pytest.raises(OSError):
        os.write(descriptor, b"x")
    os.close(descriptor)
    assert not os.path.lexists(tmp_path / "servos")
    emulator.plug_in()
    assert len(exchange(emulator, "FF FF FD 00 01 03 00 01 19 4E")) == 14


def test_misuse_is_refused():
    with pytest.raises(BackendError, match="same id"):
        ServoEmulator((1, 1))
    emulator = ServoEmulator((1, 2))
    with pytest.raises(BackendError, match="not plugged in"):
        _ = emulator.port
    with pytest.raises(BackendError, match="no such servo.*allowed: 1, 2"):
        emulator.servo(3)
    with emulator, pytest.raises(BackendError, match="runs already"):
        emulator.open()
    emulator.stop()
