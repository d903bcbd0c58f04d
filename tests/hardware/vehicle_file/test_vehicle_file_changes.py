"""Values written into a vehicle file: comments and order stay, and no file is left that cannot be read."""

from __future__ import annotations

import os
import tomllib

import numpy as np
import pytest

from doorman.exceptions import ScenarioError
from doorman.hardware.vehicle_file import VehicleFile, write_values

TEXT = """\
# My vehicle, 2.9 kg

[servos] # the arm
# from base to tip
ids = [1, 2,
       3]  # three
zero_positions = [2048, 2048, 2048]  # never measured

[mocap]
connection = "udp:51001"
# the end
"""


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(TEXT, encoding="utf-8")
    return path


def test_only_the_value_changes(path):
    write_values(path, {"servos.zero_positions": np.array([1, 2, 3])})
    assert path.read_text(encoding="utf-8") == TEXT.replace("[2048, 2048, 2048]", "[1, 2, 3]")


def test_new_keys_and_tables_are_added_and_the_rest_stays(path):
    write_values(path, {"mocap.object_position": (0.1, -0.2, 0.3), "pixhawk.thrust_curve.hover_thrust": 0.41,
                        "pixhawk.thrust_curve.hover_force": 28.5})  # fmt: skip
    text = path.read_text(encoding="utf-8")
    assert all(line in text.splitlines() for line in TEXT.splitlines())
    tables = tomllib.loads(text)
    assert tables["mocap"]["object_position"] == [0.1, -0.2, 0.3]
    assert tables["pixhawk"] == {"thrust_curve": {"hover_thrust": 0.41, "hover_force": 28.5}}
    assert VehicleFile.load(path).values["servos.ids"] == (1, 2, 3)


@pytest.mark.parametrize(
    ("value", "field"),
    [({"servos.zeros": [1]}, "servos.zeros"), ({"servos.zero_positions": [1.5]}, "servos.zero_positions.0")],
)
def test_what_does_not_fit_is_not_written(path, value, field):
    with pytest.raises(ScenarioError) as caught:
        write_values(path, value)
    assert caught.value.field == field
    assert path.read_text(encoding="utf-8") == TEXT
    assert os.listdir(path.parent) == ["my.toml"], "nothing is left beside it"


def test_a_file_that_cannot_be_read_is_left_alone(path):
    path.write_text("[servos\n")
    with pytest.raises(ScenarioError, match="not valid TOML"):
        write_values(path, {"rate": 100.0})
    with pytest.raises(ScenarioError, match="cannot be read"):
        write_values(path.with_name("none.toml"), {"rate": 100.0})


def test_rights_and_a_link_to_the_file_stay(path, tmp_path):
    path.chmod(0o640)
    link = tmp_path / "link.toml"
    link.symlink_to(path)
    write_values(link, {"rate": 100.0})
    assert link.is_symlink() and path.stat().st_mode & 0o777 == 0o640
    assert VehicleFile.load(path).values["rate"] == 100.0
