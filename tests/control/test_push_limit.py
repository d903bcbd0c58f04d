"""What the rotors push with at the leaf is bounded, whatever was planned."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from doorman.control.push_limit import limited
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.planning.limits import largest_push
from doorman.scenario import Scenario
from doorman.signals import Command

angles = st.floats(-0.6, 0.6)


def beyond(command: Command, weight: float) -> np.ndarray:
    return command.thrust * rotation_body_to_world(command.attitude)[:, 2] - np.array([0.0, 0.0, weight])


@given(st.floats(0.3, 2.5), angles, angles, st.floats(-7.0, 7.0), st.floats(5.0, 200.0), st.floats(0.5, 60.0))
def test_no_command_pushes_harder_and_all_push_the_same_way(share, roll, pitch, yaw, weight, most):
    given = Command(share * weight, np.array([roll, pitch, yaw]), np.array([0.1, -0.2]), True)
    wanted, command = beyond(given, weight), limited(given, weight, most)
    pushed = beyond(command, weight)
    assert np.linalg.norm(pushed) <= most * (1.0 + 1e-9) or command is given
    if np.linalg.norm(wanted) <= most:
        assert command is given, "to the bit"
        return
    assert np.allclose(pushed, most * wanted / np.linalg.norm(wanted), atol=1e-6 * weight)
    assert command.attitude[2] == yaw and command.grip and command.arm_rates is given.arm_rates


@pytest.mark.parametrize("most", [2.0, 12.0])
def test_the_check_knows_the_bound(most):
    model = Model(Scenario.load("push", {"control.max_push": most, "control.max_tilt": 0.6}))
    assert largest_push(model, 0.6) == pytest.approx(
        min(most, largest_push(Model(Scenario.load("push")), 0.6)), rel=0.3
    )
    assert largest_push(model, 0.6) <= most
