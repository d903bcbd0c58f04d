"""Layouts: every curve is one that a recorded run has, and both programs get the same."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree as xml

import pytest
from command_line import run as doorman

import doorman as package
from doorman.recording.layouts import PANELS, STATE


@pytest.fixture(scope="module")
def flown():
    keys = {"mission.start": "contact", "simulation.door_sensor.kind": "encoder"}
    return package.simulate(package.Scenario.load("paper", overrides=keys), duration=1.0)


def paths() -> list[str]:
    return [path for panel in PANELS for path in panel.paths]


@pytest.mark.parametrize("path", [*paths(), STATE])
def test_every_curve_is_recorded(path, flown):
    topic, field, index = re.fullmatch(r"(\w+)\.(\w+)(?:\[(\d+)\])?", path).groups()
    shape = flown[topic][field].shape[1:]
    assert shape == () if index is None else int(index) < shape[0]


def leaves(layout: Any) -> Iterator[str]:
    if isinstance(layout, str):
        yield layout
        return
    assert layout["direction"] in ("row", "column") and 0.0 < layout["splitPercentage"] < 100.0
    yield from leaves(layout["first"])
    yield from leaves(layout["second"])


def test_foxglove_gets_every_panel():
    layout = json.loads(doorman("layout", "foxglove").stdout)
    assert sorted(leaves(layout["layout"])) == sorted(layout["configById"])
    shown = [path["value"] for config in layout["configById"].values() for path in config["paths"]]
    assert sorted(shown) == sorted([*paths(), STATE])


def test_plotjuggler_gets_every_panel():
    root = xml.fromstring(doorman("layout", "plotjuggler").stdout)
    assert sorted(curve.get("name") for curve in root.iter("curve")) == sorted(p.replace(".", "/", 1) for p in paths())
    for splitter in root.iter("DockSplitter"):
        assert int(splitter.get("count")) == len(splitter) == len(splitter.get("sizes").split(";"))
