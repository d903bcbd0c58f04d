"""Emulated servos, asked with dynamixel-sdk and raw bytes, as the e-manual says: packets, table, rates, motion, protection."""

from __future__ import annotations

import os

import dynamixel_sdk as sdk
import numpy as np
import pytest
from servo_client import Client, PatientPort, exchange
from virtual_time import CLOCK

from doorman.clocks import REAL_TIME
from doorman.exceptions import BackendError
from doorman.rig.emulators.servos import ServoEmulator
from doorman.rig.emulators.servos.bus import BusFaults, LaggingJoints, ServoBusLogic
from doorman.rig.emulators.servos.packets import BROADCAST, HEADER, Instruction, checksum
from doorman.rig.emulators.servos.table import UNITS
from doorman.rig.emulators.servos.unit import ENCODER, OVERHEATING, OVERLOAD, READY, EmulatedServo, ServoSetup

ACCESS, RANGE, LIMIT, LENGTH = 7, 4, 6, 5
BAUD_RATE, MODE, TORQUE, LED, ERROR, WATCHDOG, GOAL_VELOCITY, VELOCITY, POSITION = 8, 11, 64, 65, 70, 98, 104, 128, 132
RATES = {9600: 0, 57_600: 1, 115_200: 2, 1_000_000: 3, 2_000_000: 4, 3_000_000: 5, 4_000_000: 6}
XM430 = {"model number": 1030, "firmware version": 38}
PING = "FF FF FD 00 01 03 00 01 19 4E"


# ---------------------------------------------------------------- bytes of the manual


ONE, TWO = "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0", "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"
FIRST, SECOND = "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D", "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"


@pytest.mark.parametrize(
    ("packet", "answer"),
    [
        (PING, FIRST),
        ("FF FF FD 00 FE 03 00 01 31 42", FIRST + SECOND),
        ("FF FF FD 00 01 07 00 02 84 00 04 00 1D 15", ONE),
        ("FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA", ONE + TWO),
        ("FF FF FD 00 01 40 00 02 84" + PING, FIRST),
    ],
    ids=["ping", "broadcast ping", "read", "sync read", "torn packet"],
)
def test_exchanges_of_the_manual(make_emulator, packet, answer):
    angles = [(166 - 2048) * np.pi / 2048, (2079 - 2048) * np.pi / 2048]
    emulator = make_emulator([ServoSetup(1, READY | XM430), ServoSetup(2, READY | XM430)], angles=angles)
    if "40 00 02 84" in packet:  # the line falls silent after it
        assert exchange(emulator, packet[: -len(PING)]) == b""
        packet = PING
    assert exchange(emulator, packet) == bytes.fromhex(answer)


def test_unknown_instructions_and_damaged_ones_are_refused(make_emulator):
    emulator = make_emulator([1])
    unknown = HEADER + bytes.fromhex("01 03 00 77")
    assert exchange(emulator, (unknown + checksum(unknown).to_bytes(2, "little")).hex())[8] == 2
    assert exchange(emulator, "FF FF FD 00 01 03 00 01 19 4F")[8] == 3
    assert exchange(emulator, "FF FF FD 00 01 03 00 08 2F 4F")[8] == 3
    assert exchange(emulator, PING)[8] == 0, "the damaged reboot was carried out"


# ---------------------------------------------------------------- control table


@pytest.mark.parametrize(
    ("address", "size", "value", "error"),
    [
        (0, 2, 1, ACCESS),  # read-only
        (POSITION, 4, 1, ACCESS),
        (300, 1, 1, ACCESS),  # nothing there
        (TORQUE, 1, 2, RANGE),
        (9, 1, 255, RANGE),
        (GOAL_VELOCITY, 4, 131, LIMIT),
        (GOAL_VELOCITY, 4, -131, LIMIT),
        (GOAL_VELOCITY, 4, 2000, RANGE),
        (GOAL_VELOCITY, 2, 5, LENGTH),
        (WATCHDOG, 1, 200, RANGE),
        (168, 2, 63, RANGE),  # EEPROM cannot be shown through indirect data
        (GOAL_VELOCITY, 4, -130, 0),
        (65, 1, 1, 0),
    ],
)
def test_writes_are_checked(client, address, size, value, error):
    assert client.write(address, size, value) == error


@pytest.mark.parametrize(("address", "size", "value"), [(MODE, 1, 3), (168, 2, 65)], ids=["EEPROM", "indirect address"])
def test_what_is_locked_while_torque_is_on(client, address, size, value):
    assert client.write(TORQUE, 1, 1) == 0
    before = client.read(address, size)
    assert client.write(address, size, value) == ACCESS
    assert client.read(address, size) == before
    assert client.write(TORQUE, 1, 0) == 0
    assert client.write(address, size, value) == 0
    assert client.packets.readTxRx(client.port, 1, 14, 6)[1:] == (sdk.COMM_SUCCESS, ACCESS), "a gap"


def test_indirect_data_show_and_set_what_their_addresses_name(client):
    for index, address in enumerate((65, 104, 105, 106, 107, 132)):
        assert client.write(168 + 2 * index, 2, address) == 0
    assert client.write(224, 1, 1) == 0
    assert client.read(65, 1) == 1
    assert client.write(225, 4, -50) == 0
    assert client.read(GOAL_VELOCITY, 4) == -50
    assert client.write(225, 4, -500) == LIMIT
    assert client.write(225, 2, 3) == LENGTH
    assert client.write(229, 1, 3) == ACCESS
    assert client.write(578, 2, 65) == 0
    assert client.read(634, 1) == 1


def test_writes_may_cover_several_registers_but_all_or_nothing(client):
    assert client.packets.writeTxRx(client.port, 1, 104, 8, [10, 0, 0, 0, 7, 0, 0, 0]) == (sdk.COMM_SUCCESS, 0)
    assert (client.read(104, 4), client.read(108, 4)) == (10, 7)
    assert client.packets.writeTxRx(client.port, 1, 104, 8, [20, 0, 0, 0, 0, 0, 1, 0]) == (sdk.COMM_SUCCESS, RANGE)
    assert (client.read(104, 4), client.read(108, 4)) == (10, 7)


@pytest.mark.parametrize(("level", "read", "write"), [(0, False, False), (1, True, False), (2, True, True)])
def test_status_return_level(client, level, read, write):
    client.packets.write1ByteTxOnly(client.port, 1, 68, level)
    client.port.is_using = False
    CLOCK.sleep(0.02)
    assert client.packets.ping(client.port, 1)[1] == sdk.COMM_SUCCESS
    assert (client.packets.read1ByteTxRx(client.port, 1, 68)[1] == sdk.COMM_SUCCESS) == read
    assert (client.packets.write1ByteTxRx(client.port, 1, 65, 1)[0] == sdk.COMM_SUCCESS) == write


# ---------------------------------------------------------------- rate of the port


class QuickPort(PatientPort):
    """A port that is not patient where nobody is awaited."""

    def setPacketTimeout(self, packet_length: int) -> None:
        self.setPacketTimeoutMillis(30.0)


@pytest.fixture
def scan(make_emulator):
    """Rates at which servo 1 of an emulator answers to a ping."""

    def answers(emulator, rates):
        port, packets = QuickPort(emulator.port), sdk.PacketHandler(2.0)
        found = []
        for rate in rates:
            assert port.setBaudRate(rate)
            if packets.ping(port, 1)[1] == sdk.COMM_SUCCESS:
                found.append(rate)
        port.closePort()
        return found

    return answers


@pytest.mark.parametrize("rate", RATES)
def test_a_scan_finds_a_servo_at_its_own_rate_alone(make_emulator, scan, rate):
    emulator = make_emulator([ServoSetup(1, {"baud rate": RATES[rate]})])
    assert scan(emulator, [*RATES, 19_200, 460_800]) == [rate]


def test_servos_of_one_bus_may_differ(make_emulator):
    emulator = make_emulator([ServoSetup(1), ServoSetup(2, READY | {"baud rate": 1}), ServoSetup(3)])
    client = Client(emulator)
    found, _ = client.packets.broadcastPing(client.port)
    client.port.closePort()
    assert sorted(found) == [1, 3]


def test_what_comes_at_another_rate_is_neither_obeyed_nor_heard():
    servo = EmulatedServo(ServoSetup(1))
    bus = ServoBusLogic([servo], LaggingJoints([0.0]), BusFaults(), None)
    light = Instruction(1, 0x03, bytes((LED, 0, 1)), True)
    assert bus.respond(1.0, Instruction(1, 0x03, bytes((WATCHDOG, 0, 5)), True), 1_000_000) != []
    assert bus.respond(1.0, Instruction(1, 0x03, bytes((TORQUE, 0, 1)), True), 1_000_000) != []
    for now in (1.05, 1.09):
        assert bus.respond(now, light, 57_600) == bus.respond(now, light, 19_200) == []
    assert servo.memory.get("led") == 0
    bus.tick(1.11)
    assert servo.memory.get("bus watchdog") == 0xFF, "it feeds the watchdog"


def test_a_rate_that_is_written_holds_from_the_next_packet_on(connect, scan):
    emulator, client = connect()
    assert client.write(BAUD_RATE, 1, 2) == 0, "the answer still comes at the old one"
    assert client.packets.ping(client.port, 1)[1] == sdk.COMM_RX_TIMEOUT
    assert scan(emulator, RATES) == [115_200]


def test_a_rate_that_the_port_does_not_show_is_answered(make_emulator):
    serial = pytest.importorskip("serial")
    emulator = make_emulator([1], clock=REAL_TIME)
    with serial.Serial(emulator.port, 4_500_000, timeout=0.5) as port:
        port.write(bytes.fromhex(PING))
        assert len(port.read(14)) == 14


def test_who_sets_no_rate_is_heard_by_the_first_servo(make_emulator):
    emulator = make_emulator([ServoSetup(1, {"baud rate": 2})])
    assert len(exchange(emulator, PING)) == 14
    emulator.unplug()
    emulator.plug_in()
    assert len(exchange(emulator, PING)) == 14


# ---------------------------------------------------------------- motion


def rate(emulator):
    return emulator.plant.motion(CLOCK.now()).rates[0]


def test_goal_velocity_moves_the_joint_with_torque_and_in_velocity_mode(connect):
    emulator, client = connect()
    client.write(GOAL_VELOCITY, 4, 100)
    CLOCK.sleep(0.05)
    assert rate(emulator) == 0.0
    client.write(TORQUE, 1, 1)
    assert client.read(GOAL_VELOCITY, 4) == 0, "torque begins at zero velocity"
    client.write(GOAL_VELOCITY, 4, 100)
    CLOCK.sleep(0.3)
    assert client.read(VELOCITY, 4) == 100
    assert rate(emulator) == pytest.approx(100 * UNITS["goal velocity"], rel=1e-4)
    client.write(GOAL_VELOCITY, 4, 0)
    CLOCK.sleep(0.3)
    angle = emulator.plant.motion(CLOCK.now()).angles[0]
    assert angle > 0.5
    assert client.read(POSITION, 4) == 2048 + round(angle * 4096 / (2 * np.pi))
    for address, value in ((TORQUE, 0), (MODE, 3), (TORQUE, 1)):
        assert client.write(address, 1, value) == 0
    client.write(GOAL_VELOCITY, 4, 100)
    CLOCK.sleep(0.05)
    assert rate(emulator) == pytest.approx(0.0, abs=1e-3)


def test_modes_that_do_not_exist_are_refused(client):
    assert [mode for mode in range(18) if client.write(MODE, 1, mode) == 0] == [0, 1, 3, 4, 5, 16]


def test_mounting_homing_offset_and_reverse_mode(connect):
    setup = ServoSetup(1, READY | {"homing offset": 100}, zero=1000, direction=-1)
    emulator, client = connect([setup], angles=[0.5])
    ticks = round(0.5 * 4096 / (2 * np.pi))
    CLOCK.sleep(0.03)
    assert client.read(POSITION, 4) == 1000 - ticks + 100
    for reverse, sign in ((0, 1), (1, -1)):
        client.write(TORQUE, 1, 0)
        assert client.write(10, 1, reverse) == 0
        client.write(TORQUE, 1, 1)
        client.write(GOAL_VELOCITY, 4, -50)
        CLOCK.sleep(0.2)
        assert sign * rate(emulator) > 1.0
    assert client.read(VELOCITY, 4) == pytest.approx(-50, abs=1)


# ---------------------------------------------------------------- protection


def test_bus_watchdog_of_the_manual(connect):
    """The manual's example, step by step."""
    emulator, client = connect()
    client.write(WATCHDOG, 1, 2)
    CLOCK.sleep(0.15)
    assert client.read(WATCHDOG, 1) == 2, "it sleeps while torque is off"
    client.write(TORQUE, 1, 1)
    client.write(GOAL_VELOCITY, 4, 50)
    client.write(WATCHDOG, 1, 15)
    for _ in range(8):
        CLOCK.sleep(0.05)
        assert client.read(WATCHDOG, 1) == 15, "it fired though packets came"
    CLOCK.sleep(0.45)
    assert client.read(WATCHDOG, 1) == -1
    assert abs(rate(emulator)) < 0.01
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


def test_overload_takes_the_torque_until_a_reboot(connect):
    emulator, client = connect()
    client.write(TORQUE, 1, 1)
    with emulator.lock:
        emulator.servo(1).trip(OVERLOAD)
    _, result, error = client.packets.read1ByteTxRx(client.port, 1, TORQUE)
    assert (result, error) == (sdk.COMM_SUCCESS, 0x80), "alert bit"
    assert client.read(TORQUE, 1) == 0
    assert client.read(ERROR, 1) == OVERLOAD
    assert client.write(TORQUE, 1, 1) == 0x81
    assert client.read(TORQUE, 1) == 0
    client.write(168, 2, 65)
    assert client.packets.reboot(client.port, 1) == (sdk.COMM_SUCCESS, 0x80)
    assert client.packets.ping(client.port, 1)[1] == sdk.COMM_RX_TIMEOUT
    CLOCK.sleep(0.15)
    assert client.read(ERROR, 1) == 0
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


def test_heat_comes_back_after_a_reboot_and_the_position_into_one_turn(connect):
    emulator, client = connect([1], angles=[2 * np.pi + 0.3])
    with emulator.lock:
        emulator.servo(1).memory.set("present temperature", 85)
    CLOCK.sleep(0.03)
    assert client.read(ERROR, 1) == OVERHEATING
    client.packets.reboot(client.port, 1)
    CLOCK.sleep(0.15)
    assert client.read(ERROR, 1) == OVERHEATING and 0 <= client.read(POSITION, 4) < 4096


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
    faults.silent.add(1)
    assert quick.respond(5.1, read) == [], "those after a silent one stay silent, too"


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
    assert len(exchange(emulator, PING)) == 14


def test_misuse_is_refused():
    with pytest.raises(BackendError, match="same id"):
        ServoEmulator((1, 1))
    emulator = ServoEmulator((1, 2))
    with pytest.raises(BackendError, match="not plugged in"):
        _ = emulator.port
    with pytest.raises(BackendError, match="no such servo.*allowed: 1, 2"):
        emulator.servo(3)
    with emulator, pytest.raises(BackendError, match="open already"):
        emulator.open()
    emulator.stop()
