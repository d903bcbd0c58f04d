"""Whether a leaf that its own weight moves is where the vehicle comes to it."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from urdf_variants import write_edited

from doorman.feasibility.mission import stays_at_the_start
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

DOOR = urdf_directory() / "door_with_handle.urdf"
ORIGIN = '<origin xyz="0 0 0.01" rpy="0 0 1.5707963267948966"/>'


@pytest.mark.parametrize(
    ("lean", "opening", "friction", "stays"),
    [
        (-0.02, 0.0, 0.1, True),
        (0.02, 0.0, 0.5, False),
        (0.02, 0.0, 3.0, True),
        (-0.02, 0.8, 0.1, False),
        (-0.02, 0.8, 3.0, True),
    ],
)
def test_a_leaning_door_stays_where_it_is_shut_or_friction_holds_it(
    lean: float, opening: float, friction: float, stays: bool, tmp_path: Path
) -> None:
    urdf = write_edited(tmp_path / "door.urdf", DOOR, (ORIGIN, ORIGIN.replace("0 0 1.57", f"{lean} 0 1.57")))
    keys = {"door.urdf": str(urdf), "start.opening": opening, "simulation.door_friction": friction}
    model = Model(Scenario.load("shipped:pull", keys))
    (finding,) = stays_at_the_start(model)
    assert (finding.severity.value == "ok") is stays, finding.message
    if opening == 0.0 and lean > 0.0:
        assert finding.value == pytest.approx(24.0 * 9.81 * 0.45 * math.sin(lean), rel=0.1)


def test_a_plumb_door_has_no_weight_on_its_hinge() -> None:
    assert stays_at_the_start(Model("shipped:pull")) == []
