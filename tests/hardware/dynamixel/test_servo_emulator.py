"""Emulated servos: packets and control table, asked with dynamixel-sdk and with raw bytes, as the e-manual says."""

from __future__ import annotations

import dynamixel_sdk as sdk
import numpy as np
import pytest
from servo_client import exchange
from virtual_time import CLOCK

from doorman.rig.emulators.servos.packets import HEADER, checksum
from doorman.rig.emulators.servos.unit import ServoSetup

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
