"""A door on the left, turned and moved, is planned as the shipped one's image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, write_mirrored, write_moved

from doorman import Model, Planner, Scenario

MIRRORED = np.array([-1.0, 1.0, -1.0])
"""Of roll, pitch and yaw, and of the body rates. The shipped arm bends in the plane of symmetry; its first joint turns."""
ARM = np.array([-1.0, 1.0, 1.0, 1.0])


def test_the_plan_of_a_left_door_is_the_mirror_image() -> None:
    """Of a grip; `test_whole_body` has the same of a push."""
    left = {"door.urdf": "hinged_door_left", "goal.attitude": [0.0, 0.0, 7 * np.pi / 18]}
    right, mirrored = (Planner(scenario) for scenario in ("paper", Scenario.load("paper", left)))
    plans = [planner.plan(planner.model.start_state) for planner in (right, mirrored)]
    assert plans[1].usable and plans[1].cost == pytest.approx(plans[0].cost, rel=1e-7)
    of_state, of_input = np.concatenate([MIRRORED, [1.0, 1.0], ARM]), np.concatenate([[1.0], MIRRORED, ARM])
    np.testing.assert_allclose(plans[1].states * of_state, plans[0].states, atol=2e-5)
    np.testing.assert_allclose(plans[1].inputs * of_input, plans[0].inputs, atol=2e-3)


def test_a_door_elsewhere_is_planned_alike(tmp_path: Path) -> None:
    yaw, place = 2.2, (4.0, -1.0, 0.3)
    moved = write_moved(tmp_path / "moved.urdf", write_mirrored(tmp_path / "left.urdf", DOOR), place, yaw)
    scenarios = [Scenario.load("push", {"door.urdf": str(path)}) for path in (tmp_path / "left.urdf", moved)]
    near, far = (Model(scenario) for scenario in scenarios)
    np.testing.assert_allclose(far.start_state - near.start_state, [0, 0, yaw, 0, 0, 0, 0, 0, 0], atol=1e-9)
    plans = [planner.plan(planner.planning.start_state) for planner in (Planner(near), Planner(far))]
    np.testing.assert_allclose(plans[1].inputs, plans[0].inputs, atol=1e-4)
