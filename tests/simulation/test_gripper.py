"""A gripper that holds only so much: what tears it off, what does not, and what it does afterwards."""

from __future__ import annotations

import pytest


def gripping(flight, **simulation):
    return flight(simulation__door_friction=50.0, **{f"simulation__{key}": value for key, value in simulation.items()})


@pytest.mark.parametrize(("pull", "holds"), [(2.5, True), (6.5, False)])
def test_a_pull_beyond_its_force_tears_it_off(flight, pull, holds):
    vehicle = gripping(flight, gripper_force=8.0)
    vehicle.lean(-pull)
    end = vehicle.run(1.5, every=1500)[-1]
    assert (end.gripping, end.grip_slips) == (holds, 0 if holds else 1)
    assert (end.tip_normal_force < -2.0) == holds


def test_a_push_never_tears_it_off(flight):
    vehicle = gripping(flight, gripper_force=9.0)
    vehicle.lean(8.0)
    end = vehicle.run(1.5, every=1500)[-1]
    assert end.gripping and end.max_push > 12.0


def test_force_along_the_leaf_counts(flight):
    vehicle = gripping(flight, gripper_force=3.0)
    vehicle.command(thrust=3.0 * 9.81 + 5.0)
    assert not vehicle.run(1.0, every=1000)[-1].gripping


def test_a_torn_gripper_only_pushes_until_it_was_opened(flight):
    vehicle = gripping(flight, gripper_force=5.0)
    vehicle.simulator._gripper._tie_up(False)
    vehicle.simulator._gripper._slipped = True
    for asked, holds in ((True, False), (False, False), (True, True)):
        vehicle.simulator.set_grip(asked)
        assert vehicle.simulator.truth().gripping is holds


def test_by_default_it_holds_anything(flight):
    vehicle = gripping(flight)
    vehicle.lean(-12.0)
    assert vehicle.run(1.5, every=1500)[-1].gripping


def test_a_gripper_of_no_force_never_closes(flight):
    assert not flight(simulation__gripper_force=0.0).simulator.truth().gripping
