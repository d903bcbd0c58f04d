"""What programs of others find in a recording: a profile of our own, schemas that they can walk, files as attachments."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from mcap.reader import make_reader

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
def test_every_schema_has_properties_of_known_types(tmp_path: Path, header: dict[str, Any]) -> None:
    path = tmp_path / "run.mcap"
    with Recorder(path, header, attachments={"door.urdf": b"<robot/>"}) as recorder:
        recorder.write("all", 0.0, {"states": np.zeros((51, 9)), "rates": np.zeros(3), "word": "a", "on": True, "n": 1})
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "x-doorman"
        assert [(one.name, one.data, one.media_type) for one in reader.iter_attachments()] == [
            ("door.urdf", b"<robot/>", "application/xml")
        ]
        topics = set()
        for schema, channel, message in reader.iter_messages():
            described = json.loads(schema.data)
            topics.add(channel.topic)
            jsonschema.validate(json.loads(message.data), described)
            for field in fields(described):
                assert field["type"] in KINDS
                if field["type"] == "array":
                    assert field["items"]["type"] in KINDS
    assert topics == {"header", "all"}
