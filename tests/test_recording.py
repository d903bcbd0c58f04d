"""Recording: exact round trips, files that were cut off, and every misuse a clear error."""

import json
import math
import signal
import subprocess
import sys
import textwrap
from pathlib import Path
from types import FrameType
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mcap.reader import make_reader

from doorman.exceptions import DoormanError, RecordingError
from doorman.recording import Recorder, Recording
from doorman.recording.messages import MessageType

HEADER = {"scenario": {"door": {"damping": 0.5}, "goal": {"attitude": (0.0, 0.1, -1.2)}}, "seed": 3, "version": "0.1.0"}


def assert_same(left: Recording, right: Recording) -> None:
    assert left.topics == right.topics
    assert left.header == right.header
    for name in left:
        np.testing.assert_array_equal(left[name].time, right[name].time)
        assert list(left[name]) == list(right[name])
        for field, values in left[name].items():
            np.testing.assert_array_equal(values, right[name][field])
            assert values.dtype.kind == right[name][field].dtype.kind


def test_every_type_survives_in_memory_and_in_the_file(tmp_path):
    rng = np.random.default_rng(1)
    states = rng.normal(size=(20, 51, 9)) * 10.0 ** rng.integers(-300, 300, size=(20, 51, 9))
    states[3, 4, 5], states[3, 4, 6], states[7, 0, 0] = np.nan, -np.inf, np.inf
    vectors = rng.normal(size=(20, 3))
    vectors[2] = [np.nan, np.inf, -np.inf]
    with Recorder(tmp_path / "run" / "all.mcap", HEADER) as recorder:
        for k in range(20):
            fields = {
                "number": math.nan if k == 5 else 0.1 * k,
                "integer": k - 2**62,
                "flag": k % 2 == 0,
                "text": f"α {k}",
                "vector": vectors[k],
                "matrix": states[k, :2, :3],
                "states": states[k],
                "counts": [k, k + 1],
                "names": ["leaf", "jamb"],
                "numpy_number": np.float64(k) / 3,
                "numpy_integer": np.int32(k),
                "numpy_flag": np.bool_(k > 3),
                "empty": [],
            }
            recorder.write("all", 0.1 + 0.2 * k, fields)
        memory = recorder.recording()
    loaded = Recording.load(tmp_path / "run" / "all.mcap")
    assert_same(memory, loaded)
    topic = loaded["all"]
    assert loaded.complete and memory.complete
    np.testing.assert_array_equal(topic.time, [0.1 + 0.2 * k for k in range(20)])  # not rounded to nanoseconds
    np.testing.assert_array_equal(topic["states"], states)
    np.testing.assert_array_equal(topic["vector"], vectors)
    np.testing.assert_array_equal(topic["integer"], np.arange(20) - 2**62)
    assert [topic[name].dtype.kind for name in ("number", "integer", "flag", "text", "counts")] == list("fibUi")
    assert topic["flag"].tolist() == [k % 2 == 0 for k in range(20)]
    assert topic["text"][7] == "α 7" and topic["names"].shape == (20, 2) and topic["empty"].shape == (20, 0)
    assert loaded.header == json.loads(json.dumps(HEADER))
    assert loaded.summary is None
    with pytest.raises(ValueError):
        topic["number"][0] = 1.0


@settings(max_examples=40, deadline=None)
@given(
    hnp.arrays(np.float64, hnp.array_shapes(max_dims=3, min_side=0, max_side=6)),
    st.integers(-(2**63), 2**63 - 1),
    st.text(st.characters(exclude_characters="\0")),
)
def test_json_round_trip_is_exact(array, integer, text):
    fields = {"array": array, "integer": integer, "text": text}
    kind = MessageType.of("topic", fields)
    row = kind.row(0.25, fields)
    twin = MessageType.from_schema("topic", json.loads(json.dumps(kind.schema())))
    assert twin.fields == kind.fields
    _, columns = twin.columns([twin.decode(kind.encode(row))])
    np.testing.assert_array_equal(columns["array"][0], array)
    assert columns["array"].shape == (1, *array.shape)
    assert columns["integer"][0] == integer and columns["text"][0] == text


def test_file_is_standard_mcap_with_json_schemas(tmp_path):
    path = tmp_path / "run.mcap"
    with Recorder(path, HEADER) as recorder:
        for k in range(300):
            recorder.write("command", 0.01 * k, {"thrust": 29.43 + k, "arm_rates": np.full(4, k)})
            recorder.write("plan", 0.01 * k, {"states": np.full((51, 9), 0.1 * k)})
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)  # the indexed reader, which Recording.load does not use
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
        assert json.loads(metadata["header"]["scenario"])["door"]["damping"] == 0.5
        counts = {"header": 0, "command": 0, "plan": 0}
        for schema, channel, message in reader.iter_messages():
            assert schema.encoding == "jsonschema" and channel.message_encoding == "json"
            jsonschema.validate(json.loads(message.data), json.loads(schema.data))
            if channel.topic == "command":
                assert message.log_time == counts["command"] * 10_000_000
            counts[channel.topic] += 1
    assert counts == {"header": 1, "command": 300, "plan": 300}


def test_values_are_copied_when_written():
    recorder = Recorder(None, {})
    vector = np.zeros(3)
    recorder.write("topic", 0.0, {"vector": vector})
    vector[:] = 1.0
    recorder.write("topic", 0.1, {"vector": vector})
    snapshot = recorder.recording()
    recorder.write("topic", 0.2, {"vector": vector})
    np.testing.assert_array_equal(snapshot["topic"]["vector"][:, 0], [0.0, 1.0])
    assert len(recorder.recording()["topic"].time) == 3


FIRST = {"angle": 1.0, "rates": np.zeros(3), "count": 1, "touching": False, "status": "ok"}


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"extra": 1.0}, "topic"),
        ({"angle": None}, "topic.angle"),
        ({"angle": True}, "topic.angle"),
        ({"angle": "1.0"}, "topic.angle"),
        ({"angle": np.zeros(1)}, "topic.angle"),
        ({"rates": np.zeros(4)}, "topic.rates"),
        ({"rates": 0.0}, "topic.rates"),
        ({"rates": ["a", "b", "c"]}, "topic.rates"),
        ({"rates": [1.0, [2.0], 3.0]}, "topic.rates"),
        ({"count": 1.5}, "topic.count"),
        ({"count": 2**63}, "topic.count"),
        ({"touching": 1}, "topic.touching"),
        ({"status": 3}, "topic.status"),
    ],
)
def test_other_fields_than_the_first_message_are_refused_whole(tmp_path, change, field):
    path = tmp_path / "run.mcap"
    with Recorder(path, {}) as recorder:
        recorder.write("topic", 0.0, FIRST)
        with pytest.raises(RecordingError) as error:
            recorder.write("topic", 0.1, FIRST | change)
        assert error.value.field == field
        with pytest.raises(RecordingError):
            recorder.write("topic", 0.1, {"angle": 1.0})
        recorder.write(
            "topic", 0.2, FIRST | {"angle": 3, "rates": [1, 2, 3], "count": np.int8(4)}
        )  # whole numbers are numbers
        memory = recorder.recording()
    assert_same(memory, Recording.load(path))
    assert memory["topic"].time.tolist() == [0.0, 0.2]
    assert memory["topic"]["rates"][1].tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize(
    ("topic", "moment", "fields"),
    [
        ("topic", 0.0, {"value": None}),
        ("topic", 0.0, {"value": object()}),
        ("topic", 0.0, {"value": [[1.0], [1.0, 2.0]]}),
        ("topic", 0.0, {"value": [1.0, "two"]}),
        ("topic", 0.0, {"value": b"bytes"}),
        ("topic", 0.0, {"value": 1j}),
        ("topic", 0.0, {"value": 2**70}),
        ("topic", 0.0, {"value": np.zeros(2, dtype=np.uint64)}),
        ("topic", 0.0, {"time": 0.0}),
        ("header", 0.0, {"value": 1.0}),
        ("topic", -0.1, {"value": 1.0}),
        ("topic", math.nan, {"value": 1.0}),
        ("topic", 1e300, {"value": 1.0}),
    ],
)
def test_what_cannot_be_recorded_leaves_no_trace(topic, moment, fields):
    recorder = Recorder(None, {})
    with pytest.raises(RecordingError):
        recorder.write(topic, moment, fields)
    assert recorder.recording().topics == ()
    recorder.write("topic", 0.0, {"value": 1.0})


def test_unknown_names_list_the_known_ones():
    recorder = Recorder(None, {})
    recorder.write("truth", 0.0, {"door_angle": 1.0, "door_rate": 0.0})
    recording = recorder.recording()
    with pytest.raises(RecordingError, match="allowed: truth"):
        recording["trut"]
    with pytest.raises(DoormanError, match="door_angle, door_rate"):
        recording["truth"]["angle"]
    assert "estimate" not in recording and recording.get("estimate") is None and "door_rate" in recording["truth"]


@pytest.mark.parametrize("header", [{"seed": math.nan}, {"seed": object()}])
def test_header_that_json_cannot_hold(header):
    with pytest.raises(RecordingError):
        Recorder(None, header)


def test_header_takes_arrays_and_paths():
    header = {"gain": np.array([1.0, 2.0]), "file": Path("a") / "b.toml", "seed": np.int64(3), "nothing": None}
    assert Recorder(None, header).header == {"gain": [1.0, 2.0], "file": "a/b.toml", "seed": 3, "nothing": None}


def test_closed_recorder_refuses_messages(tmp_path):
    recorder = Recorder(tmp_path / "run.mcap", {})
    recorder.write("topic", 0.0, {"value": 1.0})
    recorder.close()
    recorder.close()
    with pytest.raises(RecordingError, match="closed"):
        recorder.write("topic", 0.1, {"value": 1.0})
    assert recorder.recording()["topic"]["value"].tolist() == [1.0]


def test_every_truncation_gives_a_prefix(tmp_path):
    whole_path, cut_path = tmp_path / "whole.mcap", tmp_path / "cut.mcap"
    with Recorder(whole_path, HEADER) as recorder:
        for k in range(200):
            recorder.write("estimate", 0.004 * k, {"state": np.full(9, 0.1 * k)})
            if k % 5 == 0:
                recorder.write("plan", 0.004 * k, {"states": np.full((51, 9), k / 3), "status": "ok"})
    data = whole_path.read_bytes()
    whole = Recording.load(whole_path)
    lengths = []
    for size in [*range(0, len(data), len(data) // 60), *range(len(data) - 12, len(data) + 1)]:
        cut_path.write_bytes(data[:size])
        try:
            cut = Recording.load(cut_path)
        except RecordingError:
            assert size < 1000  # only where not even the header is there
            continue
        assert cut.complete == (size == len(data))
        assert cut.header == whole.header
        for name, topic in cut.items():
            m = len(topic.time)
            for field, values in topic.items():
                np.testing.assert_array_equal(values, whole[name][field][:m])
        lengths.append(len(cut["estimate"].time) if "estimate" in cut else 0)
    assert lengths == sorted(lengths) and lengths[0] == 0 and lengths[-1] == 200 and len(set(lengths)) > 5


def test_corrupted_chunk_ends_the_recording_before_it(tmp_path):
    path = tmp_path / "run.mcap"
    with Recorder(path, {}) as recorder:
        for k in range(500):
            recorder.write("topic", 0.01 * k, {"value": float(k)})
    with path.open("rb") as stream:
        chunks = make_reader(stream).get_summary().chunk_indexes
    middle = chunks[len(chunks) // 2]
    data = bytearray(path.read_bytes())
    data[middle.chunk_start_offset + middle.chunk_length - 5] ^= 0xFF
    path.write_bytes(data)
    recording = Recording.load(path)
    values = recording["topic"]["value"]
    assert not recording.complete
    assert 0 < len(values) < 500
    np.testing.assert_array_equal(values, np.arange(len(values)))


@pytest.mark.parametrize("content", [b"", b"\x89MCAP", b"time,angle\n0.0,1.5\n" * 20, b"\x89MCAP0\r\n"])
def test_files_that_hold_no_recording(tmp_path, content):
    path = tmp_path / "bad.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError) as error:
        Recording.load(path)
    assert error.value.file == str(path)


def test_mcap_of_somebody_else_and_missing_file(tmp_path):
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("camera", "json", writer.register_schema("image", "jsonschema", b"{}"))
        writer.add_message(channel, 0, b"{}", 0)
        writer.finish()
    with pytest.raises(RecordingError, match="no header"):
        Recording.load(path)
    with pytest.raises(RecordingError, match="cannot be read"):
        Recording.load(tmp_path / "missing.mcap")


def test_path_that_cannot_be_opened(tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(RecordingError, match="cannot be written"):
        Recorder(tmp_path / "file" / "run.mcap", {})
    with pytest.raises(RecordingError, match="cannot be written"):
        Recorder(tmp_path, {})


full_disk = Path("/dev/full")


def test_full_disk_keeps_memory_and_is_told_once_at_close():
    recorder = Recorder(full_disk, {})  # every write to this device fails with ENOSPC
    for k in range(1000):
        recorder.write("topic", 0.01 * k, {"value": float(k)})
    np.testing.assert_array_equal(recorder.recording()["topic"]["value"], np.arange(1000.0))
    assert not recorder.recording().complete
    with pytest.raises(RecordingError, match="No space left"):
        recorder.close()
    recorder.close()
    with pytest.raises(ZeroDivisionError) as error, Recorder(full_disk, {}):
        raise ZeroDivisionError
    assert "No space left" in error.value.__notes__[0]


def test_disk_that_fills_up_leaves_a_readable_file(tmp_path):
    script = """
        import resource, signal, sys
        from pathlib import Path
        from doorman.exceptions import RecordingError
        from doorman.recording import Recorder
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))
        recorder = Recorder(Path(sys.argv[1]), {})
        for k in range(20_000):
            recorder.write("topic", 0.001 * k, {"value": 1 / (k + 1)})
        assert len(recorder.recording()["topic"].time) == 20_000
        try:
            recorder.close()
        except RecordingError:
            print("told")
    """
    path = tmp_path / "run.mcap"
    result = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), path], capture_output=True, text=True, timeout=60
    )
    assert result.stdout == "told\n", result.stderr
    recording = Recording.load(path)
    values = recording["topic"]["value"]
    assert not recording.complete and 100 < len(values) < 20_000
    np.testing.assert_array_equal(values, 1 / np.arange(1.0, len(values) + 1))


RECORDING_PROCESS = """
    import sys, time
    from pathlib import Path
    import numpy as np
    from doorman.recording import Recorder
    recorder = Recorder(Path(sys.argv[1]), {"seed": 7})
    state, k = np.arange(9) / 7, 0
    with recorder:
        while k < 1_000_000:
            recorder.write("estimate", 0.004 * k, {"state": k * state, "step": k})
            if k % 3 == 0:
                recorder.write("mission", 0.004 * k, {"state": "open"})
            k += 1
            sys.stdout.buffer.write(b"%d\\n" % k)
            sys.stdout.flush()
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_killed_process_leaves_a_readable_recording(tmp_path, number):
    path = tmp_path / "run.mcap"
    command = [sys.executable, "-c", textwrap.dedent(RECORDING_PROCESS), str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdout is not None
        for _ in range(2003):
            process.stdout.readline()
        process.send_signal(number)
        written = max([2003, *(int(line) for line in process.stdout.read().split())])
        process.wait(timeout=30)
    recording = Recording.load(path)
    estimate = recording["estimate"]
    steps = estimate["step"]
    np.testing.assert_array_equal(steps, np.arange(len(steps)))
    np.testing.assert_array_equal(estimate["state"], steps[:, None] * (np.arange(9) / 7))
    assert recording.header == {"seed": 7}
    if number == signal.SIGINT:
        assert recording.complete and len(steps) >= written  # closed by the context manager: nothing is lost
    else:
        assert not recording.complete and (written - len(steps)) * 0.004 < 0.5


def test_interrupt_at_any_line_leaves_whole_messages(tmp_path):
    """Ctrl-C strikes at the n-th line that `write` runs, for every n, those of the MCAP library included."""
    path = tmp_path / "run.mcap"
    recorder = Recorder(path, {})
    lines = struck_at = 0

    def strike(frame: FrameType, event: str, _: object) -> Any:
        nonlocal lines
        lines += event == "line"
        if lines == struck_at:
            sys.settrace(None)
            signal.raise_signal(signal.SIGINT)
        return strike

    interrupts, k, previous_trace = 0, 0, sys.gettrace()
    previous_handler = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        while lines >= struck_at:
            lines, struck_at, k = 0, struck_at + 1, k + 1
            recorder.flush()
            recorder.write(f"topic {k}", 0.2 * k, {"step": -k, "state": np.full(9, -k / 3)})
            try:
                sys.settrace(strike)
                recorder.write(f"topic {k}", 0.2 * k + 0.2, {"step": k, "state": np.full(9, k / 3)})  # writes the batch
                sys.settrace(None)
            except KeyboardInterrupt:
                interrupts += 1
    finally:
        sys.settrace(previous_trace)
        signal.signal(signal.SIGINT, previous_handler)
    recorder.close()
    recording, memory = Recording.load(path), recorder.recording()
    assert interrupts == k - 1 > 300 and recording.complete and len(recording) == k
    for recorded in (recording, memory):
        for i in range(1, k + 1):
            steps = recorded[f"topic {i}"]["step"]
            assert steps.tolist() in ([-i], [-i, i])
            np.testing.assert_array_equal(recorded[f"topic {i}"]["state"], steps[:, None] / 3 * np.ones(9))
    assert recording[f"topic {k}"]["step"].tolist() == [-k, k]  # the last one was not struck
