"""A door on the left, turned and moved, is planned as the shipped one's image."""

from __future__ import annotations

import numpy as np
import pytest

from doorman import Planner, Scenario

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
