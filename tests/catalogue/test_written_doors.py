"""Sixty doors as other authors write them: read as they are, or asked about."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from written_door import WrittenDoor

from doorman.exceptions import DoormanError
from doorman.feasibility.inputs.setup import setup_findings
from doorman.kinematics.doors.reading import read_door
from doorman.model import Model
from doorman.scenario import ContactSection, Scenario

COUNT = 60
RIGHT_ANGLE = 7
"""A door that is shut at the end of a range that is a right angle, rounded."""


def test_doors_are_read_as_they_are(tmp_path: Path) -> None:
    """None is read wrongly without a question, and at most three are not read."""
    unreadable, wrong, asked = [], [], 0
    for number in range(COUNT):
        drawn = WrittenDoor.drawn(number)
        file = drawn.write(tmp_path / f"{number}.urdf")
        try:
            door = read_door(Scenario(door={"urdf": str(file), "leaf": drawn.names[0], "hinge": drawn.names[1]}))
        except DoormanError as error:
            unreadable.append(f"{number}: {error}")
            continue
        asked += door.closed_is_guessed
        touched = door.place_on_face(ContactSection())
        along = [math.cos(drawn.azimuth), math.sin(drawn.azimuth), 0.0]
        opens = drawn.opens * np.cross([0.0, 0.0, 1.0], along)
        faults = {
            "closed": abs(door.closed - drawn.closed) > 1e-3 and not door.closed_is_guessed,
            "width": abs(door.width - drawn.width) > 2e-3,
            "height": abs(door.height - drawn.height) > 2e-3,
            "contact": not (0.0 < touched[0] < door.width and 0.0 < touched[1] < door.height),
            "hinge": np.abs(door.hinge_position - drawn.hinge).max() > 2e-3,
            "along": not door.closed_is_guessed and float(door.along @ along) < 1.0 - 1e-6,
            "opens": not door.closed_is_guessed and float(door.into @ opens) < 1.0 - 1e-6,
        }
        if any(faults.values()):
            wrong.append(f"{number}: {[name for name, fault in faults.items() if fault]} of {drawn}")
    assert not wrong, "\n".join(wrong)
    assert len(unreadable) <= 3, "\n".join(unreadable)
    assert asked <= sum(not WrittenDoor.drawn(number).framed for number in range(COUNT))


def test_a_limit_that_is_rounded_keeps_no_door_shut(tmp_path: Path) -> None:
    """A joint whose zero is a right angle is shut at 1.570796."""
    drawn = WrittenDoor.drawn(RIGHT_ANGLE)
    file = drawn.write(tmp_path / "door.urdf")
    assert drawn.zero == "right angle"
    model = Model(Scenario(door={"urdf": str(file), "leaf": drawn.names[0], "hinge": drawn.names[1]}))
    (found,) = (each for each in setup_findings(model) if each.name == "hinge limits")
    assert found.ok, found.message
