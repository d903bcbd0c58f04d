"""The mission's phases on the simulator: what happens when something does not go its way."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hands import aborted_in, flown, phases
from paper_door import door_normal

from doorman import Model, Scenario
from doorman.control.motion import Glide, arm_rates_to
from doorman.control.way_out import way_out
from doorman.mission import Mission, Phase
from doorman.scenario.sections.task import MissionTimeOutsSection


def test_an_approach_that_takes_too_long_ends_in_a_hover_outside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(MissionTimeOutsSection, "approach", 0.5)
    recording, mission = flown()
    assert phases(recording) == ["hover", "approach", "retreat", "done", "end"]
    assert mission.phase is Phase.DONE
    assert mission.outcome == (False, "the phase approach took longer than 0.5 s")
    summary = recording.summary
    assert summary is not None and (summary["outcome"], summary["contact_fraction"]) == ("given up", 0.0)
    assert summary["planner_ms"]["median"] is None  # nothing was planned
    assert not recording["truth"]["touching"].any()


POOR = {
    "simulation__noise__position": 0.006, "simulation__sensors__velocity": "differenced", "simulation__sensors__rate": 100.0,
    "simulation__sensors__latency": 0.02,
}  # fmt: skip


def test_a_push_with_poses_that_are_too_noisy_ends_in_the_hover() -> None:
    recording, mission = flown(scenario="push", **POOR)
    assert phases(recording) == ["hover", "retreat", "done", "end"]
    opened, reason = mission.outcome
    assert not opened and reason.startswith("the poses are too noisy for contact: ")


def test_a_mission_that_does_not_judge_poses_goes_on() -> None:
    loop = {"vehicle__attitude_lag": 0.1, "vehicle__attitude_dead_time": 0.0}
    recording, _ = flown(on_progress=aborted_in(Phase.APPROACH), mission__measures=(), **loop, **POOR)
    assert phases(recording)[:2] == ["hover", "approach"]


def test_a_hover_that_wind_does_not_let_come_to_rest_says_so() -> None:
    """A wind that turns round every three seconds."""
    recording, mission = flown(pull=lambda time: 6.5 * math.copysign(1.0, math.sin(2.0 * time)))
    assert phases(recording) == ["hover", "retreat", "done", "end"]
    opened, reason = mission.outcome
    assert not opened and reason.startswith("the vehicle did not come to hover still within 15 s: it moved by up to ")
    assert "and felt wind of up to " in reason


def test_a_gripped_door_that_has_not_come_to_rest_at_the_goal_in_time_is_held_there() -> None:
    recording, mission = flown(scenario="paper", mission__start="contact", mission__time_out__open=5.5)
    assert phases(recording) == ["touch", "open", "hold", "done", "end"]
    assert "the door did not come to rest" in list(recording["mission"]["message"])
    assert mission.outcome == (True, "")
    assert abs(recording["truth"]["door_angle"][-1] - mission.model.goal_angle) < math.radians(1.0)


def test_an_abort_lets_go_of_the_door_and_leaves_the_doorway() -> None:
    def stop_midway(mission: Mission, time: float, angle: float) -> None:
        if angle < math.radians(60.0):
            mission.abort("the operator said so")

    recording, mission = flown(scenario="paper", on_progress=stop_midway, mission__start="contact")
    assert phases(recording) == ["touch", "open", "release", "retreat", "done", "end"]
    assert mission.outcome == (False, "the operator said so")
    truth, summary = recording["truth"], recording.summary
    assert summary is not None and summary["collisions"] == 0 and summary["min_clearance_m"] > 0.0
    assert truth["position"][-1, 0] < -0.8 and not truth["touching"][-1]
    assert np.linalg.norm(truth["velocity"][-1]) < 0.3


def test_a_gripper_that_opens_does_not_push_a_door_without_friction() -> None:
    """Damping alone would let it coast on by degrees from a touch of two newtons."""
    hinge = {"simulation__door_damping": 2.0, "simulation__door_friction": 0.0}
    recording, mission = flown(scenario="paper", mission__start="contact", **hinge)
    assert mission.outcome == (True, "")
    assert {"release", "hold"} & set(phases(recording))
    summary = recording.summary
    assert summary is not None and summary["collisions"] == 0
    assert abs(summary["final_door_angle_deg"] - 20.0) < 1.0


@pytest.mark.slow
def test_a_gripped_door_without_friction_comes_to_rest_at_the_goal() -> None:
    """It rests nowhere by itself: what it is held with must be what is estimated, and not what was at some moment."""
    recording, mission = flown(
        scenario="paper", simulation__door_mass=20.0, simulation__door_damping=0.0, simulation__door_friction=0.0
    )
    assert mission.outcome == (True, "")
    assert "hold" in phases(recording), "it would drift away"
    summary = recording.summary
    assert summary is not None and summary["time_to_open_s"] < 8.0
    assert abs(summary["final_door_angle_deg"] - 20.0) < 0.15


@pytest.mark.parametrize("angle", [math.pi / 2, 1.2, 0.8, math.pi / 9])
def test_the_way_out_stays_between_the_jambs(model: Model, angle: float) -> None:
    """From where the vehicle stands at this angle, turned as much as the door but for 20°."""
    attitude = np.array([0.0, 0.0, -(math.pi / 2 - angle)])
    position = model.coupling.vehicle_position(attitude, angle, model.goal_arm)
    glide, radius, width = Glide(position, float(attitude[2])), model.vehicle.radius, model.door.width
    for target in way_out(model, position, angle):
        while not glide.near(target, 0.01):
            glide.to(target, 0.0, 0.25, np.zeros(model.n_arm), 0.01)
            off = door_normal(angle) @ (position - glide.position)
            assert off > -0.08, "not into the leaf"
            if abs(glide.position[0]) < radius:
                lowest, highest = min(0.0, position[1] - radius), max(width, position[1] + radius)
                assert lowest - 0.01 < glide.position[1] - radius and glide.position[1] + radius < highest + 0.01
    assert glide.position[0] < -radius - 0.5


@pytest.mark.parametrize("width", [1.05, 1.07, 1.2])
def test_the_way_out_of_a_narrow_doorway_does_not_push_the_leaf_on(width: float) -> None:
    """The disc is nearer to the jamb there than it should be, and the leaf is where it would go aside to."""
    model = Model(Scenario.load("paper", {"door.width": width}))
    angle = model.goal_angle
    place = model.coupling.vehicle_position(model.goal_state[:3], angle, model.goal_arm) + 0.1 * model.door.along
    normal, at = model.door.normal(angle), place
    for target in way_out(model, place, angle):
        assert normal @ (target - at) < 1e-9
        at = target


def test_the_arm_goes_straight_to_a_posture() -> None:
    """A joint that saturates alone would take the arm past postures that nobody has checked."""
    begin, target = np.array([0.1, 1.1, -0.8, -0.25]), np.array([0.0, 1.57, -1.57, 0.0])
    angles, way = begin.copy(), target - begin
    for _ in range(400):
        rates = arm_rates_to(target, angles)
        assert np.abs(rates).max() <= 0.5 + 1e-12
        angles = angles + 0.01 * rates
        share = (angles - begin) @ way / (way @ way)
        np.testing.assert_allclose(angles, begin + share * way, atol=1e-12)
    np.testing.assert_allclose(angles, target, atol=1e-2)
    assert arm_rates_to(np.zeros(0), np.zeros(0)).shape == (0,), "a stick has no joints"


def test_a_glide_keeps_speed_and_acceleration() -> None:
    glide, target, last = Glide(np.zeros(3), 0.0), np.array([0.4, -0.3, 0.2]), np.zeros(3)
    for _ in range(3000):
        setpoint = glide.to(target, 1.0, 0.15, np.zeros(4), 0.004)
        assert np.linalg.norm(setpoint.velocity) <= 0.15 + 1e-9
        assert np.linalg.norm(setpoint.velocity - last) <= 0.25 * 0.004 + 1e-9
        last = setpoint.velocity
    np.testing.assert_allclose(glide.position, target, atol=2e-3)
    assert glide.yaw == pytest.approx(1.0)
