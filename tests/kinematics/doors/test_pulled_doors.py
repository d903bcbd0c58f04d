"""Doors seen from the side that they are pulled open from, and where the tip touches them, against Pinocchio."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest
from urdf_variants import write_edited, write_mirrored, write_moved

from doorman.exceptions import ScenarioError, UrdfError
from doorman.kinematics.doors.reading import read_door, read_travel
from doorman.kinematics.doors.variants.true_door import TrueDoor
from doorman.model import Model
from doorman.resources import urdf_directory
from doorman.scenario import Scenario, SimulationSection

HANDLES = urdf_directory() / "door_with_handle.urdf"
OPENINGS = (0.0, 0.3, 1.2, 1.8)


def scenario(urdf: Path = HANDLES, **overrides: Any) -> Scenario:
    keys = {key.replace("__", "."): value for key, value in overrides.items()}
    return Scenario.load(
        "shipped:paper", {"start.door_angle": None, "goal.door_angle": None, "door.urdf": str(urdf), **keys}
    )


def frame_at(urdf: Path, name: str, value: float) -> tuple[np.ndarray, np.ndarray]:
    """Origin and x axis of a frame at a joint value, by Pinocchio."""
    model = pinocchio.buildModelFromUrdf(str(urdf))
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, np.array([value]))
    placement = data.oMf[model.getFrameId(name)]
    return placement.translation.copy(), placement.rotation[:, 0].copy()


@pytest.fixture(scope="module", params=["shipped", "mirrored", "elsewhere"])
def handles(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("doors") / f"{request.param}.urdf"
    if request.param == "mirrored":
        return write_mirrored(path, HANDLES)
    return HANDLES if request.param == "shipped" else write_moved(path, HANDLES, (1.0, -2.0, 0.3), 2.5)


@pytest.mark.parametrize("side", ["pull", "push"])
def test_the_tip_touches_the_contact_frame_wherever_the_door_is(handles: Path, side: str) -> None:
    model = Model(scenario(handles, contact__frame=f"handle_{side}"))
    assert model.door.side == side
    for opening in OPENINGS:
        angle = model.door.angle_of_opening(opening)
        assert model.door.joint_value(angle) == pytest.approx(opening)
        assert model.door.angle_of_joint(opening) == pytest.approx(angle)
        point, outward = frame_at(handles, f"handle_{side}", opening)
        np.testing.assert_allclose(model.coupling.contact_point(angle), point, atol=1e-9)
        np.testing.assert_allclose(model.door.normal(angle), -outward, atol=1e-9)
        assert model.door.angle_of(point - model.door.hinge_position) == pytest.approx(angle)
        yaw = model.door.heading(angle)
        np.testing.assert_allclose([math.cos(yaw), math.sin(yaw)], -outward[:2], atol=1e-9)


def test_a_pulled_door_moves_towards_the_vehicle(handles: Path) -> None:
    for side, sense in (("pull", 1.0), ("push", -1.0)):
        model = Model(scenario(handles, contact__frame=f"handle_{side}"))
        first, last = (model.coupling.contact_point(angle) for angle in (model.travel.start, model.travel.goal))
        assert sense * float((last - first) @ model.door.into) < 0.0
        assert model.travel.sense == sense


def test_the_side_follows_from_the_ends_where_nothing_else_names_it() -> None:
    assert read_door(scenario()).side == "push"
    assert read_door(scenario(goal__door_angle=2.2)).side == "pull"
    assert read_door(scenario(start__door_angle=2.2, goal__door_angle=1.58)).side == "pull"
    assert read_door(scenario(contact__side="pull")).side == "pull"


def test_an_opening_is_measured_from_the_closed_door() -> None:
    for side, sense in (("pull", 1.0), ("push", -1.0)):
        task = scenario(contact__side=side, start__opening=0.4, goal__opening=1.1)
        travel = read_travel(task, read_door(task))
        assert travel.start == pytest.approx(0.5 * math.pi + sense * 0.4)
        assert travel.goal == pytest.approx(0.5 * math.pi + sense * 1.1)
        default = scenario(contact__side=side)
        travel = read_travel(default, read_door(default))
        assert travel.start == pytest.approx(0.5 * math.pi) and travel.length == pytest.approx(math.radians(70.0))


def test_the_goal_of_a_door_that_opens_little_is_its_limit(tmp_path: Path) -> None:
    door = write_edited(tmp_path / "door.urdf", HANDLES, ('upper="1.9"', 'upper="0.9"'))
    for side in ("pull", "push"):
        task = scenario(door, contact__side=side)
        assert read_travel(task, read_door(task)).length == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("overrides", "field"),
    [
        ({"contact__frame": "handle_pull", "contact__side": "push"}, "contact.side"),
        ({"goal__opening": 1.0, "goal__door_angle": 0.5}, "goal.opening"),
        ({"start__opening": 1.0, "start__door_angle": 0.5}, "start.opening"),
    ],
)
def test_what_contradicts_itself_is_refused(overrides: dict[str, Any], field: str) -> None:
    with pytest.raises(ScenarioError) as caught:
        Model(scenario(**overrides))
    assert caught.value.field == field


def test_frames_that_are_none_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UrdfError, match="no link 'knob'"):
        Model(scenario(contact__frame="knob"))
    with pytest.raises(UrdfError, match="does not move with the leaf"):
        Model(scenario(contact__frame="frame"))
    askew = write_edited(tmp_path / "door.urdf", HANDLES, ('rpy="0 0 -1.5707963267948966"', 'rpy="0 0 -1.2"'))
    with pytest.raises(UrdfError, match="does not look away from the leaf"):
        Model(scenario(askew, contact__frame="handle_pull"))


def test_a_true_door_keeps_its_side_and_handle() -> None:
    task = scenario(contact__frame="handle_pull")
    moved = SimulationSection(door_offset=(0.1, 0.2, 0.0), door_yaw=0.3)
    true, told = TrueDoor(HANDLES, task.door, moved, "pull", task.contact), read_door(task)
    assert true.side == "pull" and true.handle == pytest.approx(told.handle)
    assert true.heading(2.0) == pytest.approx(told.heading(2.0) + 0.3)
