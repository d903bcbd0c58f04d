"""A door on the left, turned and moved, is planned as the shipped one's image."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from urdf_variants import DOOR, write_mirrored, write_moved

from doorman import Model, Planner, Scenario
from doorman.planning.quasi_static_planning import push_state

MIRRORED = np.array([-1.0, 1.0, -1.0])
"""Of roll, pitch and yaw, and of the body rates. The shipped arm bends in the plane of symmetry; its first joint turns."""
ARM = np.array([-1.0, 1.0, 1.0, 1.0])


@pytest.mark.parametrize("scenario", ["paper", "push"])
def test_the_plan_of_a_left_door_is_the_mirror_image(scenario: str) -> None:
    left = {"door.urdf": "hinged_door_left"}
    if scenario == "paper":
        left["goal.attitude"] = [0.0, 0.0, 7 * np.pi / 18]  # type: ignore[assignment]
    one, other = Planner(scenario), Planner(Scenario.load(scenario, left))
    plans = []
    for planner in (one, other):
        start = planner.model.start_state
        if scenario == "push":
            planner.update_door(friction=0.3, disturbance=-1.2)
            start = push_state(planner.model, start, 1.2)
        plans.append(planner.plan(start))
    right, mirrored = plans
    assert mirrored.usable and mirrored.cost == pytest.approx(right.cost, rel=1e-7)
    of_state, of_input = np.concatenate([MIRRORED, [1.0, 1.0], ARM]), np.concatenate([[1.0], MIRRORED, ARM])
    np.testing.assert_allclose(mirrored.states * of_state, right.states, atol=2e-5)
    np.testing.assert_allclose(mirrored.inputs * of_input, right.inputs, atol=2e-3)


def test_a_door_elsewhere_is_planned_alike(tmp_path: Path) -> None:
    yaw, place = 2.2, (4.0, -1.0, 0.3)
    moved = write_moved(tmp_path / "moved.urdf", write_mirrored(tmp_path / "left.urdf", DOOR), place, yaw)
    scenarios = [Scenario.load("push", {"door.urdf": str(path)}) for path in (tmp_path / "left.urdf", moved)]
    near, far = (Model(scenario) for scenario in scenarios)
    np.testing.assert_allclose(far.start_state - near.start_state, [0, 0, yaw, 0, 0, 0, 0, 0, 0], atol=1e-9)
    costs = [Planner(model).plan(push_state(model, model.start_state, 1.2)).cost for model in (near, far)]
    assert costs[1] == pytest.approx(costs[0], rel=1e-9)
