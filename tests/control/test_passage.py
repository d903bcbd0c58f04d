"""The way through a doorway, against plane geometry."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from doorman.control.passage import BEHIND, NEEDED, OFF, Passage, behind_the_door, has_doorway
from doorman.model import Model
from doorman.scenario import Scenario

THROUGH = {"mission.then": "through"}


def model_of(source: str, **overrides: Any) -> Model:
    return Model(Scenario.load(f"shipped:{source}", {key.replace("__", "."): each for key, each in overrides.items()}))


@pytest.mark.parametrize("opening", [1.25, 1.3, 1.396])
def test_the_clearance_is_half_of_what_leaf_and_jamb_leave(opening: float) -> None:
    model = model_of("through", goal__opening=opening)
    passage = Passage(model)
    edge = model.door.width * math.cos(opening - OFF)  # of the leaf, along the doorway
    left = model.door.width - edge - 2.0 * model.vehicle.radius
    # 13 ways beside each other miss the middle by half of their distance at most
    assert passage.clearance.distance == pytest.approx(left / 2.0, abs=0.03)
    assert passage.clear == (passage.clearance.distance >= NEEDED)
    along = float((passage.exit - model.door.hinge_position) @ model.door.along)
    assert along == pytest.approx((edge + model.door.width) / 2.0, abs=0.03)


@pytest.mark.parametrize("source", ["push", "push_left"])
def test_entrance_and_exit_are_outside_on_both_sides(source: str) -> None:
    model = model_of(source, goal__opening=1.396, goal__door_angle=None, mission__then="through")
    passage = Passage(model)
    assert passage.clear and passage.outside(passage.entrance) and not passage.outside(passage.exit)
    assert passage.into(passage.exit) == pytest.approx(model.door.frame_back + BEHIND)
    assert behind_the_door(model, passage.exit) and not behind_the_door(model, passage.entrance)
    level = (passage.exit - passage.entrance) / np.linalg.norm(passage.exit - passage.entrance)
    assert level @ model.door.into == pytest.approx(1.0) and passage.yaw == pytest.approx(model.door.azimuth)


def test_drawers_and_hatches_have_no_doorway() -> None:
    assert has_doorway(model_of("pull"))
    assert not any(has_doorway(model_of(source)) for source in ("drawer", "hatch", "sliding"))
