"""Without any key of reality the plant is as it is told to be, to the bit, and does no more work."""

from __future__ import annotations

import numpy as np
import pytest

ARRAYS = (
    "body_mass",
    "body_ipos",
    "body_inertia",
    "body_iquat",
    "dof_frictionloss",
    "dof_damping",
    "actuator_gear",
    "qpos0",
)


@pytest.mark.parametrize("kind", ["grip", "push"])
def test_values_that_say_what_is_told_anyway_change_no_bit(flight, kind):
    told = flight(contact__kind=kind)
    same = flight(contact__kind=kind, simulation__vehicle_mass=3.0, simulation__gripper_force=1e6,
                  simulation__gust__jump_rate=1.0, simulation__sensors__jump=0.1)  # fmt: skip
    for name in ARRAYS:
        np.testing.assert_array_equal(*(getattr(one.plant.engine_model, name) for one in (told, same)), err_msg=name)
    for one in (told, same):
        one.lean(2.0)
    ends = [one.run(0.3, every=300)[-1] for one in (told, same)]
    for name in ("position", "attitude", "tip_force", "rotor_thrusts"):
        np.testing.assert_array_equal(*(getattr(end, name) for end in ends), err_msg=name)
    assert ends[0].door_angle == ends[1].door_angle
