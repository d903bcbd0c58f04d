"""What the links are told of the vehicle, from a scenario and the command line."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.cli.numbers import real_numbers
from doorman.exceptions import DoormanError
from doorman.hardware.vehicle import vehicle_config
from doorman.model import Model
from doorman.scenario import Scenario


def test_the_local_frame_goes_from_the_command_line_to_the_autopilot_s_link():
    given = real_numbers("-1.5,2,0.25,1.5707963267948966", "--local-frame", 4)
    frame = vehicle_config(Model(Scenario()), "udp:14540", "/dev/null", local_frame=given).pixhawk.local_frame
    np.testing.assert_allclose(frame.position_to_world([3.0, 0.0, -1.0]), [-1.5, 5.0, 1.25], atol=1e-12)  # 3 m north
    assert frame.yaw == pytest.approx(0.5 * math.pi)
    assert real_numbers(None, "--local-frame", 4) is None
    world = vehicle_config(Model(Scenario()), "udp:14540", "/dev/null").pixhawk.local_frame
    np.testing.assert_allclose(world.position_to_world([3.0, 0.0, -1.0]), [3.0, 0.0, 1.0], atol=1e-12)


@pytest.mark.parametrize("text", ["", "1,2,3", "1,2,3,4,5", "1,2,3,north", "1,2,3,nan", "1,2,3,inf"])
def test_other_frames_are_errors_that_name_the_option(text):
    with pytest.raises(DoormanError, match="--local-frame.*4 finite numbers"):
        real_numbers(text, "--local-frame", 4)
