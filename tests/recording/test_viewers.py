"""What programs of others find in a recording: a profile of our own, messages of ROS 2, files as attachments."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from doorman.mission import simulate
from doorman.recording import Recorder

KINDS = ("boolean", "string", "number", "integer", "object", "array")
"""Types that viewers know."""


def fields(schema: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Every field of a schema and of its objects, as a viewer walks them."""
    for field in schema["properties"].values():
        yield field
        if field["type"] == "object":
            yield from fields(field)


@pytest.mark.parametrize(
    "header",
    [
        {},
        {"seed": 3, "name": "paper", "none": None, "flag": True},
        {"scenario": {"door": {"urdf": "door", "gains": [1, 2.5]}, "empty": {}, "odd": [1, "two"], "deep": [[1], [2]]}},
        {"links": [{"a": 1}, {"a": 2}], "words": ["a", "b"], "nothing": []},
    ],
)
def test_the_header_has_properties_of_known_types(tmp_path: Path, header: dict[str, Any]) -> None:
    path = tmp_path / "run.mcap"
    with Recorder(path, header, attachments={"door.urdf": b"<robot/>"}) as recorder:
        recorder.write("all", 0.0, {"states": np.zeros((51, 9)), "rates": np.zeros(3), "word": "a", "on": True, "n": 1})
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "x-doorman"
        assert [(one.name, one.data, one.media_type) for one in reader.iter_attachments()] == [
            ("door.urdf", b"<robot/>", "application/xml")
        ]
        (schema, message) = next(
            (one, sent) for one, channel, sent in reader.iter_messages() if channel.topic == "header"
        )
    described = json.loads(schema.data)
    jsonschema.validate(json.loads(message.data), described)
    for field in fields(described):
        assert field["type"] in KINDS
        if field["type"] == "array":
            assert field["items"]["type"] in KINDS


def as_ros2_reads(path: Path) -> dict[str, list[Any]]:
    """Messages of every topic but the header, by rosbags, which knows the format from ROS 2 alone."""
    store, found = get_typestore(Stores.EMPTY), {}
    with path.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            if channel.topic == "header":
                continue
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            if schema.name not in store.types:
                store.register(get_types_from_msg(schema.data.decode(), schema.name))
            found.setdefault(channel.topic, []).append(store.deserialize_cdr(message.data, schema.name))
    return found


def test_messages_are_those_of_ros2(tmp_path: Path) -> None:
    """Of every kind, in every order, with names that ROS 2 does not have, and texts of any length behind the numbers."""
    path = tmp_path / "run.mcap"
    with Recorder(path, {}) as recorder:
        for k in range(3):
            message = {
                "on": k == 1, "word": "α" * k, "states": np.full((5, 3), k + 0.5), "angle": 0.25 * k,
                "flags": [True, False, k == 2],
                "n": k - 2**40, "single": np.full(3, 0.1 * k, dtype=np.float32), "counts": np.arange(k, k + 2), "nothing": [],
                "names": ["leaf", "x" * k], "Gyr[0]": 1.5, "Gyr[1]": 2.5, "gyr_0": 3.5, "7": k, "°": -k,
            }  # fmt: skip
            recorder.write("all/of it", 0.1 * k, message)
            recorder.write("2 numbers", 0.1 * k, {"a": float(k)})
            recorder.write("same", 0.1 * k, {"word": "open", "a": float(k)})
    found = as_ros2_reads(path)
    assert [one.a for one in found["2 numbers"]] == [0.0, 1.0, 2.0]
    assert [(one.word, one.a) for one in found["same"]] == [("open", 0.0), ("open", 1.0), ("open", 2.0)]
    for k, one in enumerate(found["all/of it"]):
        assert (one.time, one.on, one.word, one.angle, one.n) == (0.1 * k, k == 1, "α" * k, 0.25 * k, k - 2**40)
        np.testing.assert_array_equal(one.states, np.full(15, k + 0.5))
        np.testing.assert_array_equal(one.single, np.full(3, 0.1 * k, dtype=np.float32))
        assert one.flags.tolist() == [True, False, k == 2] and one.counts.tolist() == [k, k + 1]
        assert one.names == ["leaf", "x" * k] and not hasattr(one, "nothing")
        assert (one.Gyr_0, one.Gyr_1, one.gyr_0_2, one.field_7, one.field) == (1.5, 2.5, 3.5, k, -k)


def test_what_a_flight_records_is_of_ros2(model: Any, tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    recording = simulate(model, 0.1, path=path, force=True)
    found = as_ros2_reads(path)
    assert set(found) == set(recording.topics)
    for topic, messages in found.items():
        assert [one.time for one in messages] == recording[topic].time.tolist()
    angles = [one.door_angle for one in found["truth"]]
    assert angles == recording["truth"]["door_angle"].tolist()
    assert [one.collision_pairs for one in found["truth"]] == recording["truth"]["collision_pairs"].tolist()
