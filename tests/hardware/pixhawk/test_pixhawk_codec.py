"""Bytes to messages: damage, resynchronisation, versions, signing, and a sample of the fuzzer."""

from __future__ import annotations

import random

import pytest
from pixhawk_fuzz import Fuzzer
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from doorman.exceptions import BackendError
from doorman.hardware.pixhawk.link.inbox import WANTED
from doorman.hardware.pixhawk.wire.codec import Codec, load_key, signing_time

KEY = bytes(range(32))


def vehicle(key: bytes | None = None):
    mav = mavlink.MAVLink(None, 1, 1)
    if key is not None:
        mav.signing.secret_key, mav.signing.sign_outgoing = key, True
        mav.signing.timestamp = signing_time()
    return mav


def packets(count: int, mav=None) -> list[bytes]:
    mav = mav or vehicle()
    made = []
    for stamp in range(1, count + 1):
        made.append(mavlink.MAVLink_local_position_ned_message(stamp, 1, 2, 3, 4, 5, 6).pack(mav))
        mav.seq = (mav.seq + 1) % 256
    return made


def stamps(messages) -> list[int]:
    return [message.time_boot_ms for message in messages]


@pytest.fixture
def codec():
    return Codec(255, 190, None, WANTED)


def test_messages_come_out_whatever_the_bytes_are_cut_into(codec):
    data = b"".join(packets(20))
    chance = random.Random(3)
    found, at = [], 0
    while at < len(data):
        step = chance.randint(1, 60)
        found += codec.decode(data[at : at + step], "wire")
        at += step
    assert stamps(found) == list(range(1, 21))
    assert codec.counters.corrupted == 0


def test_noise_between_messages_costs_none_of_them(codec):
    noise = b"\x00\xfd\xfe\x09\xff"
    data = noise + noise.join(packets(10)) + noise + bytes(300)
    assert stamps(codec.decode(data, "wire")) == list(range(1, 11))


@pytest.mark.parametrize("byte", [1, 2, 5, 7, 12, 30, None])
def test_a_damaged_or_cut_packet_is_dropped_and_the_next_ones_are_not(codec, byte):
    made = packets(12)
    damaged = bytearray(made[0])
    if byte is None:
        del damaged[20:]
    else:
        damaged[byte] ^= 0x55
    assert stamps(codec.decode(bytes(damaged) + b"".join(made[1:]), "wire")) == list(range(2, 13))


def test_senders_do_not_mix(codec):
    first, second = packets(1)[0], packets(1, mavlink.MAVLink(None, 2, 1))[0]
    assert codec.decode(first[:10], "a") == []
    assert len(codec.decode(second, "b")) == 1
    assert len(codec.decode(first[10:], "a")) == 1


def test_many_senders_do_not_fill_the_memory(codec):
    for sender in range(1000):
        codec.decode(b"\xfd\x20\x00", sender)
    assert len(codec._splitters) <= 16


def test_the_older_protocol_is_read_too(codec):
    mav = vehicle()
    data = mavlink.MAVLink_heartbeat_message(2, 3, 81, 4, 3, 3).pack(mav, force_mavlink1=True)
    (message,) = codec.decode(data, "wire")
    assert (message.custom_mode, message.get_srcSystem()) == (4, 1)


def test_a_message_of_no_interest_that_is_defined_otherwise_is_not_damage(codec):
    """PX4's ESC_STATUS has another checksum than pymavlink's, and bytes in it that look like headers of heartbeats."""
    made = packets(3)
    other = mavlink.MAVLink_rc_channels_message(0, 18, *[254] * 18, 0).pack(vehicle())
    foreign = other[:-2] + bytes([other[-2] ^ 0x5A, other[-1]])
    found = codec.decode(made[0] + foreign + made[1] + foreign + made[2], "wire")
    assert stamps(found) == [1, 2, 3]
    assert codec.counters.corrupted == 0


def test_a_header_of_no_interest_in_the_noise_costs_no_message_however_the_bytes_come(codec):
    data = bytes([0xFD, 200, 0, 0, 1, 1, 1, 35, 1, 0]) + b"".join(packets(11)) + bytes(300)
    found = [message for byte in data for message in codec.decode(bytes([byte]), "wire")]
    assert stamps(found) == list(range(1, 12))


def test_messages_of_no_interest_are_not_decoded(codec):
    data = mavlink.MAVLink_vfr_hud_message(1.0, 1.0, 1, 1, 1.0, 1.0).pack(vehicle())
    assert codec.decode(data, "wire") == []
    assert codec.counters.messages == 1


def test_our_messages_count_on_and_are_ours(codec):
    reader = mavlink.MAVLink(None, 1, 1)
    for number in range(300):
        heartbeat = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
        (message,) = reader.parse_buffer(codec.encode(heartbeat))
        assert message.get_seq() == number % 256
        assert (message.get_srcSystem(), message.get_srcComponent()) == (255, 190)


# ---------------------------------------------------------------- signing


def test_signed_messages_are_exchanged(codec):
    ours = Codec(255, 190, KEY, WANTED)
    assert stamps(ours.decode(b"".join(packets(3, vehicle(KEY))), "wire")) == [1, 2, 3]
    reader = vehicle(KEY)
    (message,) = reader.parse_buffer(ours.encode(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)))
    assert message.get_signed()


@pytest.mark.parametrize("key", [None, bytes(32)], ids=["unsigned", "of another key"])
def test_messages_without_our_signature_are_rejected(key):
    ours = Codec(255, 190, KEY, WANTED)
    assert ours.decode(b"".join(packets(3, vehicle(key))), "wire") == []
    assert ours.counters.bad_signatures == 3


def test_a_signed_message_counts_once():
    ours = Codec(255, 190, KEY, WANTED)
    (packet,) = packets(1, vehicle(KEY))
    assert len(ours.decode(packet + packet, "wire")) == 1


def test_a_forged_stamp_does_not_shut_out_the_real_stream():
    ours = Codec(255, 190, KEY, WANTED)
    (packet,) = packets(1, vehicle(KEY))
    forged = bytearray(packet)
    forged[-12:-6] = b"\xff" * 6
    assert ours.decode(bytes(forged), "wire") == [] and len(ours.decode(packet, "wire")) == 1


def test_an_old_recording_is_not_accepted_but_its_old_clock_is_noticed():
    ours, mav = Codec(255, 190, KEY, WANTED), vehicle(KEY)
    (forged,) = packets(1, vehicle(bytes(32)))
    assert ours.decode(forged, "wire") == [] and not ours.outdated
    mav.signing.timestamp -= 120 * 100_000
    assert ours.decode(packets(1, mav)[0], "wire") == [] and ours.outdated


def test_a_computer_whose_clock_is_behind_takes_the_time_from_the_vehicle():
    ours, mav = Codec(255, 190, KEY, WANTED), vehicle(KEY)
    mav.signing.timestamp += 3600 * 100_000
    assert len(ours.decode(packets(1, mav)[0], "wire")) == 1
    packet = ours.encode(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))
    assert int.from_bytes(packet[-12:-6], "little") > mav.signing.timestamp - 100_000


def test_a_signed_message_is_read_without_a_key(codec):
    assert len(codec.decode(packets(1, vehicle(KEY))[0], "wire")) == 1


@pytest.mark.parametrize("content", [KEY, KEY.hex().encode(), KEY.hex().upper().encode() + b"\n"])
def test_keys_come_raw_or_in_hexadecimal(tmp_path, content):
    file = tmp_path / "key"
    file.write_bytes(content)
    file.chmod(0o600)
    assert load_key(file) == KEY


@pytest.mark.parametrize("content", [b"", b"short", b"x" * 64, b"ab" * 33, bytes(200)])
def test_what_is_no_key_is_refused(tmp_path, content):
    file = tmp_path / "key"
    file.write_bytes(content)
    file.chmod(0o600)
    with pytest.raises(BackendError, match="not a signing key"):
        load_key(file)


def test_a_key_that_others_may_read_is_refused(tmp_path):
    file = tmp_path / "key"
    file.write_bytes(KEY)
    file.chmod(0o644)
    with pytest.raises(BackendError, match="others may read"):
        load_key(file)
    with pytest.raises(BackendError, match="cannot be read"):
        load_key(tmp_path / "none")


# ---------------------------------------------------------------- fuzzing


@pytest.mark.parametrize("seed", range(4))
def test_a_sample_of_the_fuzzer(seed):
    fuzzer = Fuzzer(seed)
    for _ in range(1000):
        fuzzer.once()
    counters = fuzzer.link.codec.counters
    assert counters.messages > 200 and counters.corrupted > 50


def test_after_all_that_the_link_still_works():
    fuzzer = Fuzzer(99)
    for _ in range(300):
        fuzzer.feed(fuzzer.noise())
    for _ in range(20):
        fuzzer.feed(bytes(280))
    before = fuzzer.link.codec.counters.messages
    fuzzer.feed(b"".join(packets(10)))
    assert fuzzer.link.codec.counters.messages == before + 10
