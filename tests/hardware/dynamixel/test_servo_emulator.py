"""Emulated servos: packets and control table, asked with dynamixel-sdk and with raw bytes, as the e-manual says."""

from __future__ import annotations

import dynamixel_sdk as sdk
import numpy as np
import pytest
from servo_client import exchange
from virtual_time import CLOCK

from doorman.rig.emulators.servos.packets import HEADER, checksum
from doorman.rig.emulators.servos.unit import READY, ServoSetup

ACCESS, RANGE, LIMIT, LENGTH = 7, 4, 6, 5
TORQUE, GOAL_VELOCITY, WATCHDOG, VELOCITY, POSITION = 64, 104, 98, 128, 132
XM430 = {"model number": 1030, "firmware version": 38}


# ---------------------------------------------------------------- bytes of the manual


def test_ping_of_the_manual(make_emulator):
    emulator = make_emulator([ServoSetup(1, dict(XM430)), ServoSetup(2, dict(XM430))])
    first = "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"
    second = "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"
    assert exchange(emulator, "FF FF FD 00 01 03 00 01 19 4E") == bytes.fromhex(first)
    assert exchange(emulator, "FF FF FD 00 FE 03 00 01 31 42") == bytes.fromhex(first + second)


def test_reads_of_the_manual(make_emulator):
    emulator = make_emulator([1, 2], angles=[(166 - 2048) * np.pi / 2048, (2079 - 2048) * np.pi / 2048])
    read = "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"
    sync_read = "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"
    one, two = "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0", "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"
    assert exchange(emulator, read) == bytes.fromhex(one)
    assert exchange(emulator, sync_read) == bytes.fromhex(one + two)


def test_bulk_instructions_of_the_manual(make_emulator):
    emulator = make_emulator([1, 2])
    with emulator.lock:
        emulator.servo(1).memory.set("present input voltage", 119)
        emulator.servo(2).memory.set("present temperature", 36)
        emulator.servo(2).memory.set("temperature limit", 70)
        emulator.servo(1).memory.set("max voltage limit", 150)
    answer = exchange(emulator, "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05")
    assert answer == bytes.fromhex("FF FF FD 00 01 06 00 55 00 77 00 C3 69 FF FF FD 00 02 05 00 55 00 24 8B A9")
    assert exchange(emulator, "FF FF FD 00 FE 10 00 93 01 20 00 02 00 A0 00 02 1F 00 01 00 50 B7 68") == b""
    assert emulator.servo(1).memory.get("max voltage limit") == 160
    assert emulator.servo(2).memory.get("temperature limit") == 80


def test_fast_sync_read_of_the_manual(make_emulator):
    emulator = make_emulator([3, 4, 7], angles=[(ticks - 2048) * np.pi / 2048 for ticks in (166, 1023, 2079)])
    read = "FF FF FD 00 FE 0A 00 8A 84 00 04 00 03 07 04 20 F2"
    head, three = "FF FF FD 00 FE 19 00 55", " 00 03 A6 00 00 00 84 08"
    seven, four = " 00 07 1F 08 00 00 16 CA", " 00 04 FF 03 00 00 D1 9E"
    assert exchange(emulator, read) == bytes.fromhex(head + three + seven + four)
    emulator.faults.silent.add(4)
    assert exchange(emulator, read) == bytes.fromhex(head + three + seven), "the last is not there"
    with emulator.lock:
        emulator.servo(7).memory.set("firmware version", 44)
    assert exchange(emulator, read) == bytes.fromhex(head + three), "the second does not know the instruction"
    emulator.faults.mute.add(3)
    assert exchange(emulator, read) == b""


def test_fast_reads_by_the_sdk(connect):
    emulator, client = connect()
    with emulator.lock:
        for servo_id in (1, 2, 3):
            emulator.servo(servo_id).memory.set("present temperature", 40 + servo_id)
            emulator.servo(servo_id).memory.set("goal velocity", 0xFDFFFF)  # what else would be stuffed
    sync = sdk.GroupSyncRead(client.port, client.packets, 104, 43)
    bulk = sdk.GroupBulkRead(client.port, client.packets)
    # The SDK looks for an id among all bytes that it has sent: none of them may be one before its turn.
    for servo_id, address, length in ((1, 104, 4), (2, 140, 7), (3, 146, 1)):
        assert sync.addParam(servo_id) and bulk.addParam(servo_id, address, length)
    assert sync.fastSyncRead() == sdk.COMM_SUCCESS
    assert [sync.getData(servo_id, 146, 1) for servo_id in (1, 2, 3)] == [41, 42, 43]
    assert [sync.getData(servo_id, 104, 4) for servo_id in (1, 2, 3)] == [0xFDFFFF] * 3
    assert bulk.fastBulkRead() == sdk.COMM_SUCCESS
    assert (bulk.getData(3, 146, 1), bulk.getData(1, 104, 4), bulk.getData(2, 146, 1)) == (43, 0xFDFFFF, 42)


@pytest.mark.parametrize("length", [1, 4, 662, 1020, 65_535])
def test_fast_reads_that_cannot_be_answered_are_not(make_emulator, length):
    """Rows that do not exist, and packets longer than any may be."""
    emulator = make_emulator([1, 2])
    rows = bytes((1, 144, 0, 1, 0)) + bytes((2, 15, 0)) + length.to_bytes(2, "little")
    read = HEADER + b"\xfe" + (len(rows) + 3).to_bytes(2, "little") + b"\x9a" + rows
    answer = exchange(emulator, (read + checksum(read).to_bytes(2, "little")).hex())
    assert len(answer) == (13 if length < 1024 - 9 else 0)
    assert len(exchange(emulator, "FF FF FD 00 01 03 00 01 19 4E")) == 14


def test_secondary_id_of_the_manual(make_emulator):
    """The manual's example, step by step, but for EEPROM, which only the servo's own id writes."""
    emulator = make_emulator([ServoSetup(number, READY | {"secondary id": 5}) for number in (1, 2, 5)])

    def light(servo_id, value, address=65):
        packet = HEADER + bytes((servo_id, 6, 0, 3, address, 0, value))
        return exchange(emulator, (packet + checksum(packet).to_bytes(2, "little")).hex())

    def lights():
        return [emulator.servo(number).memory.get("led") for number in (1, 2, 5)]

    assert light(1, 1)[4] == 1 and lights() == [1, 0, 0]
    answer = light(5, 1)
    assert (len(answer), answer[4]) == (11, 5) and lights() == [1, 1, 1], "all of them, and one answers"
    assert light(100, 0) == b"" and lights() == [1, 1, 1]
    for number in (1, 2, 5):
        assert light(number, 100, 12)[8] == 0
    assert light(100, 0) == b"" and lights() == [0, 0, 0]
    assert light(100, 77, 12) == b""
    assert [emulator.servo(number).memory.get("secondary id") for number in (1, 2, 5)] == [100] * 3
    assert light(2, 253, 12)[8] == 0
    assert light(253, 1) == b"" and lights() == [0, 0, 0], "253 and above are none"


def test_register_write_and_action_of_the_manual(make_emulator):
    emulator = make_emulator([ServoSetup(1, {"operating mode": 1, "velocity limit": 300})])
    done, refused = "FF FF FD 00 01 04 00 55 00 A1 0C", 2
    assert exchange(emulator, "FF FF FD 00 01 03 00 05 02 CE")[8] == refused, "action without register write"
    assert exchange(emulator, "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E") == bytes.fromhex(done)
    assert emulator.servo(1).memory.get("registered instruction") == 1
    assert emulator.servo(1).memory.get("goal velocity") == 0
    assert exchange(emulator, "FF FF FD 00 01 03 00 05 02 CE") == bytes.fromhex(done)
    assert emulator.servo(1).memory.get("goal velocity") == 200


def test_clear_of_the_manual_drops_whole_turns(connect):
    emulator, client = connect([ServoSetup(1, READY | {"velocity limit": 1023})])
    clear = "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC"
    client.write(TORQUE, 1, 1)
    client.write(GOAL_VELOCITY, 4, 1023)
    CLOCK.sleep(0.35)
    assert exchange(emulator, clear)[8] == 1, "it may not be cleared while it turns"
    client.write(GOAL_VELOCITY, 4, 0)
    CLOCK.sleep(0.25)
    turned = client.read(POSITION, 4)
    assert turned > 4096
    assert exchange(emulator, clear)[8] == 0
    CLOCK.sleep(0.03)
    assert client.read(POSITION, 4) == turned % 4096


def test_factory_reset_is_refused(make_emulator):
    emulator = make_emulator([1])
    assert exchange(emulator, "FF FF FD 00 01 04 00 06 01 A1 E6")[8] == 1
    assert emulator.servo(1).memory.get("operating mode") == 1


def test_unknown_instructions_and_damaged_ones_are_refused(make_emulator):
    emulator = make_emulator([1])
    unknown = HEADER + bytes.fromhex("01 03 00 77")
    assert exchange(emulator, (unknown + checksum(unknown).to_bytes(2, "little")).hex())[8] == 2
    assert exchange(emulator, "FF FF FD 00 01 03 00 01 19 4F")[8] == 3
    assert exchange(emulator, "FF FF FD 00 01 03 00 08 2F 4F")[8] == 3
    assert exchange(emulator, "FF FF FD 00 01 03 00 01 19 4E")[8] == 0, "the damaged reboot was carried out"


def test_a_torn_packet_does_not_swallow_the_next(make_emulator):
    emulator = make_emulator([1])
    assert exchange(emulator, "FF FF FD 00 01 40 00 02 84") == b""
    assert len(exchange(emulator, "FF FF FD 00 01 03 00 01 19 4E")) == 14


# ---------------------------------------------------------------- control table


def test_eeprom_is_locked_while_torque_is_on(client):
    assert client.write(11, 1, 3) == 0
    assert client.write(11, 1, 1) == 0
    assert client.write(TORQUE, 1, 1) == 0
    assert client.write(11, 1, 3) == ACCESS
    assert client.read(11, 1) == 1
    assert client.write(TORQUE, 1, 0) == 0
    assert client.write(11, 1, 3) == 0


def test_indirect_addresses_are_locked_while_torque_is_on(client):
    assert client.write(TORQUE, 1, 1) == 0
    assert client.write(168, 2, 65) == ACCESS
    assert client.write(TORQUE, 1, 0) == 0
    assert client.write(168, 2, 65) == 0


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


def test_reads_of_gaps_are_refused(client):
    _, result, error = client.packets.readTxRx(client.port, 1, 14, 6)
    assert (result, error) == (sdk.COMM_SUCCESS, ACCESS)


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
