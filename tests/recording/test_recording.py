"""Recording: exact round trips, and every misuse a clear error."""

import json
import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from mcap.reader import make_reader
from recorded import HEADER, assert_same

from doorman.exceptions import DoormanError, RecordingError
from doorman.recording import Recorder, Recording


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
    with pytest.raises(RecordingError, match="lacks the topic 'truth'"):
        _ = loaded.summary
    with pytest.raises(ValueError):
        topic["number"][0] = 1.0


@settings(max_examples=40, deadline=None)
@given(
    hnp.arrays(np.float64, hnp.array_shapes(max_dims=3, min_side=0, max_side=6)),
    st.integers(-(2**63), 2**63 - 1),
    st.text(st.characters(exclude_characters="\0")),
)
def test_a_round_trip_is_exact(array, integer, text):
    fields = {"array": array, "integer": integer, "text": text, "texts": [text, "", text], "on": True}
    with tempfile.TemporaryDirectory() as folder:
        with Recorder(Path(folder) / "run.mcap", {}) as recorder:
            recorder.write("topic", 0.25, fields)
            recorder.write("topic", 0.5, fields)
        found = Recording.load(folder)
    topic = found["topic"]
    assert found.complete and topic.time.tolist() == [0.25, 0.5] and list(topic) == list(fields)
    assert topic["array"].shape == (2, *array.shape) and topic["texts"].tolist() == 2 * [[text, "", text]]
    for k in range(2):
        np.testing.assert_array_equal(topic["array"][k], array)
        assert topic["integer"][k] == integer and topic["text"][k] == text and topic["on"][k]


def test_floats_of_32_bits_are_stored_so(tmp_path):
    path, exact = tmp_path / "run.mcap", np.arange(6.0).reshape(2, 3) / 7
    with Recorder(path, {}) as recorder:
        for k in range(2):
            recorder.write("plan", 0.1 * k, {"states": (k + exact).astype(np.float32), "single": np.float32(0.1)})
        recorder.write("plan", 0.2, {"states": 2 + exact, "single": 0.1})
        with pytest.raises(RecordingError, match=r"plan.states"):
            recorder.write("plan", 0.3, {"states": np.zeros((2, 3), dtype=int), "single": 0.1})
        memory = recorder.recording()
    loaded = Recording.load(path)
    assert_same(memory, loaded)
    assert loaded["plan"]["states"].dtype == np.float64
    np.testing.assert_array_equal(loaded["plan"]["states"][2], (2 + exact).astype(np.float32))
    assert loaded["plan"]["single"].tolist() == [float(np.float32(0.1))] * 2 + [0.1]


def test_file_is_standard_mcap_with_schemas_of_ros2(tmp_path):
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
            kinds = ("jsonschema", "json") if channel.topic == "header" else ("ros2msg", "cdr")
            assert (schema.encoding, channel.message_encoding) == kinds
            if channel.topic == "command":
                assert message.log_time == message.publish_time == counts["command"] * 10_000_000
            counts[channel.topic] += 1
    assert counts == {"header": 1, "command": 300, "plan": 300}


def test_what_is_not_kept_in_memory_is_in_the_file_and_heard(tmp_path):
    heard = []
    with Recorder(tmp_path / "rig.mcap", {}, lambda topic, *_: heard.append(topic), keep=False) as recorder:
        for tick in range(3):
            recorder.write("truth", 0.01 * tick, {"angle": float(tick)})
        with pytest.raises(RecordingError, match="not kept in memory"):
            recorder.recording()
    assert heard == ["truth"] * 3
    assert Recording.load(tmp_path / "rig.mcap")["truth"]["angle"].tolist() == [0.0, 1.0, 2.0]


@pytest.mark.parametrize("name", [None, "run.mcap"])
def test_values_are_copied_and_snapshots_stay_while_the_recorder_goes_on_to_its_end(name, tmp_path):
    recorder = Recorder(None if name is None else tmp_path / name, {"seed": 1})
    vector = np.zeros(3)
    recorder.write("topic", 0.0, {"vector": vector})
    vector[:] = 1.0
    recorder.write("topic", 0.1, {"vector": vector})
    snapshot = recorder.recording()
    recorder.write("other", 0.1, {"word": "α"})
    recorder.write("topic", 0.2, {"vector": vector})
    recorder.close()
    recorder.close()
    with pytest.raises(RecordingError, match="closed"):
        recorder.write("topic", 0.3, {"vector": vector})
    np.testing.assert_array_equal(snapshot["topic"]["vector"][:, 0], [0.0, 1.0])
    assert snapshot.topics == ("topic",) and snapshot.complete and snapshot.header == {"seed": 1}
    whole = recorder.recording()
    assert whole["topic"].time.tolist() == [0.0, 0.1, 0.2] and whole["other"]["word"].tolist() == ["α"]


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
        whole_numbers = {"angle": 3, "rates": [1, 2, 3], "count": np.int8(4)}
        recorder.write("topic", 0.2, FIRST | whole_numbers)
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
        ("topic", 0.0, {"value": [1 << 20_000, "more digits than Python prints"]}),
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
    with pytest.raises(RecordingError) as error:
        recorder.write(topic, moment, fields)
    assert str(error.value)
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


def test_a_header_takes_arrays_and_paths_and_nothing_that_json_cannot_hold():
    for seed in (math.nan, object()):
        with pytest.raises(RecordingError):
            Recorder(None, {"seed": seed})
    header = {"gain": np.array([1.0, 2.0]), "file": Path("a") / "b.toml", "seed": np.int64(3), "nothing": None}
    assert Recorder(None, header).header == {"gain": [1.0, 2.0], "file": "a/b.toml", "seed": 3, "nothing": None}
