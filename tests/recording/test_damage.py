"""Recordings that were damaged on the disk: what is whole is read, what is lost is counted, nothing is called complete."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mcap_records import ATTACHMENT, CHUNK, FOOTER, MESSAGE_INDEX, records

from doorman.exceptions import RecordingError
from doorman.recording import Recorder, Recording

HEADER = {"name": "paper", "seed": "7", "scenario": {"door": {"width": 1.2}, "goal": [0.0, 0.1]}, "none": None}
ROWS = 60


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A recording of several chunks; the topic `late` begins in the middle."""
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    with Recorder(path, HEADER, attachments={"door.urdf": b"<robot name='door'/>"}) as recorder:
        for k in range(ROWS):
            recorder.write("early", 0.05 * k, {"step": k, "state": np.full(3, k / 7), "word": f"α{k}"})
            if k >= ROWS // 2:
                recorder.write("late", 0.05 * k, {"step": k, "states": np.full((20, 9), k / 3)})
    return path.read_bytes()


def chunks(data: bytes) -> list[tuple[int, int]]:
    return [(place, len(body)) for place, opcode, body in records(data) if opcode == CHUNK]


def load(data: bytes, folder: Path) -> Recording:
    path = folder / "damaged.mcap"
    path.write_bytes(data)
    return Recording.load(path)


def assert_part_of_it(recording: Recording, lost: int) -> None:
    """Every row that is there is one that was recorded, in order, and at most so many are lost."""
    assert recording.header == HEADER
    steps = recording["early"]["step"]
    assert (np.diff(steps) > 0).all() and len(steps) >= ROWS - lost
    np.testing.assert_array_equal(recording["early"]["state"], steps[:, None] / 7 * np.ones(3))
    assert recording["early"]["word"].tolist() == [f"α{k}" for k in steps]
    late = recording["late"]["step"]
    np.testing.assert_array_equal(recording["late"]["states"], late[:, None, None] / 3 * np.ones((20, 9)))
    assert len(late) >= ROWS // 2 - lost


def test_the_whole_file_is_complete(whole, tmp_path):
    recording = load(whole, tmp_path)
    assert recording.complete and recording.damaged_chunks == 0
    assert_part_of_it(recording, 0)
    assert recording.attachments == {"door.urdf": b"<robot name='door'/>"}
    assert len(chunks(whole)) > 10


@pytest.mark.parametrize(
    "where",
    ["content", "opcode", "opcode of nothing", "opcode of an index", "opcode of the footer", "length", "longer"],
)
@pytest.mark.parametrize("closed", [True, False])
def test_a_damaged_chunk_costs_that_chunk_whichever_it_is(whole, tmp_path, where, closed):
    """In a file that was closed, and in one that was cut off, which has no summary."""
    end = len(whole) if closed else sum(chunks(whole)[-1]) + 9
    for place, length in chunks(whole)[:-1]:
        data = bytearray(whole[:end])
        if where == "content":  # a single bit of a frame may mean nothing
            middle = place + 9 + 2 * length // 3
            data[middle : middle + 4] = bytes(byte ^ 0xFF for byte in data[middle : middle + 4])
        elif where.startswith("opcode"):
            opcodes = {"opcode": 0x86, "opcode of nothing": 0, "opcode of an index": MESSAGE_INDEX}
            data[place] = opcodes.get(where, FOOTER)
        else:
            data[place + 1 + (where == "longer")] ^= 0x40
        recording = load(bytes(data), tmp_path)
        assert not recording.complete and recording.damaged_chunks == 1, place
        assert_part_of_it(recording, 5)


def test_several_damaged_chunks_are_counted(whole, tmp_path):
    data = bytearray(whole)
    for place, length in chunks(whole)[2:9:3]:
        data[place + 9 + length - 3] ^= 0xFF
    recording = load(bytes(data), tmp_path)
    assert recording.damaged_chunks == 3 and not recording.complete
    assert_part_of_it(recording, 12)


def test_any_flipped_byte_costs_at_most_its_chunk(whole, tmp_path):
    """Wherever it is: in chunks, indexes, attachments, the summary; and what is called complete is."""
    full = load(whole, tmp_path)
    rng = np.random.default_rng(5)
    for place in rng.choice(np.arange(8, len(whole)), 150, replace=False):
        data = bytearray(whole)
        data[place] ^= 1 << int(rng.integers(8))
        recording = load(bytes(data), tmp_path)
        assert_part_of_it(recording, 5)
        if recording.complete:
            assert recording.damaged_chunks == 0 and recording.attachments == full.attachments
            assert len(recording["early"].time) == ROWS and len(recording["late"].time) == ROWS // 2


def test_noise_in_the_middle_of_a_file_is_passed_over(whole, tmp_path):
    rng = np.random.default_rng(3)
    place, length = chunks(whole)[4]
    for size in (1, 100, 5000):
        noise = rng.integers(0, 256, size, dtype=np.uint8).tobytes()
        recording = load(whole[:place] + noise + whole[place:], tmp_path)
        assert not recording.complete
        assert_part_of_it(recording, 0)
    without = load(whole[:place] + whole[place + 9 + length :], tmp_path)
    assert not without.complete
    assert_part_of_it(without, 5)


def test_a_damaged_attachment_is_left_out(whole, tmp_path):
    place = next(place for place, opcode, _ in records(whole) if opcode == ATTACHMENT)
    data = bytearray(whole)
    data[whole.index(b"<robot", place) + 3] ^= 1
    recording = load(bytes(data), tmp_path)
    assert not recording.complete and recording.attachments == {}
    assert_part_of_it(recording, 0)


def test_a_file_of_damage_alone_is_refused(whole, tmp_path):
    with pytest.raises(RecordingError, match="no header"):
        load(whole[:8] + bytes(len(whole) - 8), tmp_path)
    with pytest.raises(RecordingError, match="no header"):
        load(bytes(8) + whole[8:], tmp_path)
