"""Overrides on the command line, and the scenario that comes of them."""

from __future__ import annotations

import pytest

from doorman.cli.values import parse_overrides
from doorman.exceptions import ScenarioError


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("planner.margin=0.01", "planner.margin", 0.01),
        ("contact.kind=push", "contact.kind", "push"),
        ('contact.kind="push"', "contact.kind", "push"),
        ("door.urdf=../doors/heavy.urdf", "door.urdf", "../doors/heavy.urdf"),
        ("door.urdf=my doors/heavy-2.urdf", "door.urdf", "my doors/heavy-2.urdf"),
        ("start.arm=[0, 1.0, -0.6, -0.4]", "start.arm", [0, 1.0, -0.6, -0.4]),
        (" planner.horizon_steps = 20 ", "planner.horizon_steps", 20),
        ("x=true", "x", True),
        ("mocap.sender=192.168.10.5", "mocap.sender", "192.168.10.5"),
        ("x={a = 1}", "x", {"a": 1}),
        ('x="a=b"', "x", "a=b"),
    ],
)
def test_the_value_of_an_override_is_toml_or_a_bare_word(text, key, value):
    assert parse_overrides([text]) == {key: value}


def test_the_last_override_of_a_key_wins():
    assert parse_overrides(["a.b=1", "c=2", "a.b=3"]) == {"a.b": 3, "c": 2}


@pytest.mark.parametrize(
    "text",
    ["", "=", "=3", "planner.margin", "planner margin=1", "a..b=1", ".a=1", "a=", "a=[1", 'a="b', "a=1 2", "a=1\nb = 2",
     "a=1.2.3", "a=# comment", "a='", "[a]=1", "a=" + "[" * 3000, "a=" + "9" * 5000],
    ids=lambda text: repr(text[:20]),
)  # fmt: skip
def test_what_is_no_override_is_an_error(text):
    with pytest.raises(ScenarioError) as caught:
        parse_overrides([text])
    assert caught.value.field.startswith("--set")
    assert caught.value.given is not None
    assert caught.value.allowed is not None
