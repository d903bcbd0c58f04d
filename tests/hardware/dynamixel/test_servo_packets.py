"""Packets: the e-manual's examples byte for byte, and adapter, emulator and dynamixel-sdk against each other."""

from __future__ import annotations

import pytest
from dynamixel_sdk import protocol2_packet_handler as sdk_packets
from dynamixel_sdk import robotis_def
from hypothesis import given
from hypothesis import strategies as st

from doorman.hardware.dynamixel.packets import (
    ALERT,
    BROADCAST_ID,
    StatusPacket,
    StatusParser,
    crc16,
    instruction_packet,
)
from doorman.hardware.dynamixel.registers import Instruction
from doorman.rig.emulators.servos.packets import InstructionStream, checksum, status_packet

INSTRUCTIONS = [
    (1, Instruction.PING, "", "FF FF FD 00 01 03 00 01 19 4E"),
    (0xFE, Instruction.PING, "", "FF FF FD 00 FE 03 00 01 31 42"),
    (1, Instruction.READ, "84 00 04 00", "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    (1, Instruction.WRITE, "74 00 00 02 00 00", "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89"),
    (1, Instruction.REBOOT, "", "FF FF FD 00 01 03 00 08 2F 4E"),
    (0xFE, Instruction.SYNC_READ, "84 00 04 00 01 02", "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA"),
    (0xFE, Instruction.SYNC_WRITE, "74 00 04 00 01 96 00 00 00 02 AA 00 00 00",
     "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87"),
]  # fmt: skip
STATUSES = [
    (1, 0, "06 04 26", "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"),
    (2, 0, "06 04 26", "FF FF FD 00 02 07 00 55 00 06 04 26 6F 6D"),
    (1, 0, "A6 00 00 00", "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0"),
    (2, 0, "1F 08 00 00", "FF FF FD 00 02 08 00 55 00 1F 08 00 00 BA BE"),
    (1, 0, "", "FF FF FD 00 01 04 00 55 00 A1 0C"),
    (1, 0, "77 00", "FF FF FD 00 01 06 00 55 00 77 00 C3 69"),
    (2, 0, "24", "FF FF FD 00 02 05 00 55 00 24 8B A9"),
]
"""Examples of the e-manual's page on protocol 2.0: id, instruction or error, parameters, whole packet."""

# Bytes that make headers and stuffing likely.
treacherous = st.lists(st.sampled_from([0xFF, 0xFF, 0xFF, 0xFD, 0xFD, 0x00, 0x55, 0x01]), max_size=40).map(bytes)
ids = st.integers(0, 252)


def parse(data: bytes, longest: int = 40) -> list[StatusPacket]:
    parser = StatusParser()
    parser.restart(longest)
    return parser.feed(data) + parser.finish()


@pytest.mark.parametrize(("servo_id", "instruction", "parameters", "packet"), INSTRUCTIONS)
def test_instructions_of_the_manual(servo_id, instruction, parameters, packet):
    assert instruction_packet(servo_id, instruction, bytes.fromhex(parameters)) == bytes.fromhex(packet)
    (heard,) = InstructionStream().feed(bytes.fromhex(packet))
    assert (heard.servo_id, heard.code, heard.parameters) == (servo_id, instruction, bytes.fromhex(parameters))
    assert heard.intact


@pytest.mark.parametrize(("servo_id", "error", "parameters", "packet"), STATUSES)
def test_status_packets_of_the_manual(servo_id, error, parameters, packet):
    assert status_packet(servo_id, error, bytes.fromhex(parameters)) == bytes.fromhex(packet)
    assert parse(bytes.fromhex(packet)) == [StatusPacket(servo_id, error, bytes.fromhex(parameters))]


def test_codes_are_those_of_the_sdk():
    for instruction in Instruction:
        assert getattr(robotis_def, f"INST_{instruction.name}") == instruction
    assert robotis_def.BROADCAST_ID == BROADCAST_ID
    assert sdk_packets.ERRBIT_ALERT == ALERT


@given(ids, treacherous)
def test_parameters_that_look_like_headers_arrive(servo_id, parameters):
    (heard,) = InstructionStream().feed(instruction_packet(servo_id, Instruction.WRITE, parameters))
    assert (heard.servo_id, heard.parameters, heard.intact) == (servo_id, parameters, True)
    assert parse(status_packet(servo_id, 0, parameters)) == [StatusPacket(servo_id, 0, parameters)]


@given(st.binary(max_size=60))
def test_crc_is_that_of_the_sdk(data):
    assert crc16(data) == checksum(data) == sdk_packets.Protocol2PacketHandler().updateCRC(0, data, len(data))


def test_a_lying_length_swallows_nothing_and_the_wait_ends_with_the_deadline():
    packet = bytearray(status_packet(1, 0, b"\x01\x02\x03\x04"))
    packet[5] += 40
    parser = StatusParser()
    parser.restart(4)
    assert parser.feed(bytes(packet) + status_packet(2, 0, b"\x05\x06\x07\x08")) == []
    assert parser.finish() == [StatusPacket(2, 0, b"\x05\x06\x07\x08")]
    assert parser.damaged > 0


def test_echoed_instructions_are_passed_over():
    echo = instruction_packet(1, Instruction.READ, b"\x84\x00\x04\x00")
    assert parse(echo + status_packet(1, 0, b"\x01\x02\x03\x04")) == [StatusPacket(1, 0, b"\x01\x02\x03\x04")]


def test_silence_is_not_damage():
    parser = StatusParser()
    parser.restart(4)
    parser.feed(status_packet(1, 0, b"\x01\x02\x03\x04"))
    assert parser.finish() == []
    assert parser.damaged == 0


def test_alert_and_error_number():
    (packet,) = parse(status_packet(1, 0x87))
    assert packet.alert
    assert packet.error_number == 7


def test_the_buffer_does_not_grow():
    parser = StatusParser()
    parser.restart(18)
    for _ in range(200):
        parser.feed(b"\x00" * 1000)
        parser.feed(b"\xff\xff\xfd\x00\x01\xff\xff" * 100)
    assert len(parser._bytes) < 100
