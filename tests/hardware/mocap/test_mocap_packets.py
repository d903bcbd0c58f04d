"""The parser against packets that are written out byte by byte."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.hardware.mocap.packets import ObjectPacket, TrackedObject, pack, parse
from doorman.rig.emulators.mocap.emulator import SIZES

HEADER = bytes.fromhex("0403020101")  # frame 0x01020304, one item
ITEM = bytes.fromhex("004800") + b"quad" + bytes(20)
POSE = bytes.fromhex(
    "000000000000f03f 00000000000000c0 0000000000000840 000000000000e03f 000000000000d0bf 0000000000000000"
)


def test_a_packet_byte_by_byte():
    expected = ObjectPacket(0x01020304, (TrackedObject("quad", (1.0, -2.0, 3.0), (0.5, -0.25, 0.0)),))
    assert parse(HEADER + ITEM + POSE) == expected
    assert len(HEADER + ITEM + POSE) == 80


@pytest.mark.parametrize("size", SIZES)
def test_padding_means_nothing(size):
    assert parse((HEADER + ITEM + POSE).ljust(size, b"\0")) == parse(HEADER + ITEM + POSE)
    assert parse((HEADER + ITEM + POSE).ljust(size, b"\xff")) == parse(HEADER + ITEM + POSE)


def test_several_objects_and_items_that_are_none():
    other = struct.pack("<BH", 3, 5) + b"12345"
    data = struct.pack("<IB", 9, 3) + ITEM + POSE + other + ITEM.replace(b"quad", b"wand") + POSE
    found = parse(data)
    assert isinstance(found, ObjectPacket)
    assert [one.name for one in found.objects] == ["quad", "wand"]


@pytest.mark.parametrize("name", ["x", "a" * 24, "grün"])
def test_names(name):
    data = struct.pack("<IBBH", 1, 1, 0, 72) + name.encode().ljust(24, b"\0") + POSE
    found = parse(data)
    assert isinstance(found, ObjectPacket)
    assert found.objects[0].name == name


@pytest.mark.parametrize("length", range(80))
def test_every_truncation_is_told(length):
    assert isinstance(parse((HEADER + ITEM + POSE)[:length]), str)


@pytest.mark.parametrize("size", [0, 1, 71, 73, 144, 65535])
def test_wrong_sizes_are_told(size):
    data = HEADER + struct.pack("<BH", 0, size) + b"quad" + bytes(20) + POSE + bytes(200)
    assert isinstance(parse(data), str)


def test_more_items_promised_than_sent():
    found = parse(struct.pack("<IB", 7, 2) + ITEM + POSE)
    assert isinstance(found, str) and "ends before item 2 of 2" in found


@given(st.binary(max_size=600))
def test_any_bytes_have_an_answer(data):
    found = parse(data)
    assert isinstance(found, ObjectPacket | str)
    if isinstance(found, ObjectPacket):
        assert len(found.objects) <= len(data) // 75


finite = st.floats(allow_nan=False, allow_infinity=False)


@given(st.integers(0, 2**32 - 1), st.lists(st.tuples(finite, finite, finite, finite, finite, finite), max_size=13))
def test_what_is_packed_is_what_is_parsed(number, poses):
    objects = tuple(TrackedObject(f"object {index}", pose[:3], pose[3:]) for index, pose in enumerate(poses))
    assert parse(pack(number, objects)) == ObjectPacket(number, objects)
