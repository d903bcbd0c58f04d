"""Flights with a sensor of the door: a door that stands elsewhere and ajar, sensors that fail, and the flight's own judgement."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.flown import summary_of
from doorman.mission import simulate
from doorman.model import Model
from doorman.recording import Recording
from doorman.scenario import Scenario
from doorman.summary import sentence_by_the_leaf

KEY = "simulation.door_sensor."
ELSEWHERE = {"simulation.door_offset": (0.04, -0.05, 0.0), "simulation.door_yaw": 0.05, "simulation.door_ajar": 0.25}


def flown(name: str = "push", seed: int = 1, **keys) -> Recording:
    settings = {key.replace("__", "."): value for key, value in keys.items()}
    return simulate(Scenario.load(name, settings), seed=seed, force=True)


def error(recording: Recording) -> np.ndarray:
    """Of the estimated angle, deg."""
    truth, estimate = recording["truth"], recording["estimate"]
    n = min(len(truth.time), len(estimate.time))
    return np.degrees(np.abs(estimate["state"][:n, 3] - truth["door_angle"][:n]))


def words(recording: Recording) -> list[str]:
    return [str(one) for one in recording["event"]["message"]]


@pytest.fixture(scope="module")
def beside() -> Recording:
    """A door 6 cm and 3° beside the map, which stands ajar by 14°, seen by cameras."""
    return flown(**ELSEWHERE, **{KEY + "kind": "cameras"})


def test_a_door_that_stands_elsewhere_and_ajar_is_opened(beside):
    summary = beside.summary
    assert summary["opened"] and summary["collisions"] == 0, summary["reason"]
    assert np.median(error(beside)[5:]) < 0.5
    assert words(beside)[0].startswith("the leaf is measured, at 7")


def test_the_flight_is_judged_by_the_measured_leaf(beside):
    """As a real flight is, which has no truth."""
    real = Recording({name: topic for name, topic in beside.items() if name != "truth"}, beside.header)
    judged = summary_of(real)
    assert judged["judged_by"] == "the measured leaf" and judged["opened"]
    assert judged["final_door_angle_deg"] == pytest.approx(beside.summary["final_door_angle_deg"], abs=0.5)
    assert judged["time_to_open_s"] == pytest.approx(beside.summary["time_to_open_s"], abs=0.7)
    assert judged["contact_fraction"] > 0.8
    assert "was opened in" in sentence_by_the_leaf(judged)


def test_a_frame_beyond_the_search_is_refused_in_words():
    run = flown(**{"simulation.door_offset": (0.15, 0.0, 0.0), KEY + "kind": "cameras"})
    assert "15 cm" in run.summary["reason"] and "door.position" in run.summary["reason"]
    assert not run["truth"]["touching"].any()


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["freeze", "jump", "late", "upside_down", "wrong_object", "dies"])
def test_a_sensor_that_fails_is_told_and_flown_without(fault):
    run = flown(**{KEY + "kind": "cameras", KEY + "fault": fault, KEY + "fault_opening": 0.3})
    assert run.summary["opened"] and run.summary["collisions"] == 0, (run.summary["reason"], words(run))
    assert any("any more" in one for one in words(run))


@pytest.mark.slow
def test_the_real_detector_flies():
    run = flown(**{KEY + "kind": "pictures", "simulation.door_ajar": 0.2})
    assert run.summary["opened"] and run.summary["collisions"] == 0, run.summary["reason"]
    sensor, truth = run["door_sensor"], run["truth"]
    off = sensor["door_angle"] - np.interp(sensor["leaf_time"], truth.time, truth["door_angle"])
    assert len(np.unique(sensor["leaf_time"])) > 30 and np.percentile(np.abs(off), 95) < math.radians(1.5)


def test_a_door_of_the_task_may_stand_anywhere():
    """`door.position` and `door.yaw`, as `doorman vehicle door` writes them, move the whole task."""
    here, there = Model("push"), Model(Scenario.load("push", {"door.position": (1.0, 2.0, 0.0), "door.yaw": 0.7}))
    turn = there.door.placement[:3, :3]
    np.testing.assert_allclose(there.door.hinge_position, turn @ here.door.hinge_position + [1.0, 2.0, 0.0])
    np.testing.assert_allclose(there.door.normal(1.0), turn @ here.door.normal(1.0), atol=1e-12)
    placed = [model.door.link_placements(1.0)["leaf"] for model in (here, there)]
    np.testing.assert_allclose(placed[1][:3, :3], turn @ placed[0][:3, :3], atol=1e-12)
    np.testing.assert_allclose(there.start_state[3:], here.start_state[3:], atol=1e-9)
    assert there.start_state[2] == pytest.approx(here.start_state[2] + 0.7)
    at = [
        model.coupling.vehicle_position(model.start_state[:3], model.start_angle, model.start_arm)
        for model in (here, there)
    ]
    np.testing.assert_allclose(at[1], turn @ at[0] + [1.0, 2.0, 0.0], atol=1e-9)
