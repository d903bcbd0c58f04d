"""`doorman estimate` and its replay on a short recorded push: figures, files, a mirrored door, and bad input."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import assert_bad_input, run

from doorman.control.estimation.replay import LeafReplay, replay_leaf
from doorman.estimation.leaf.numbers import part
from doorman.estimation.status import Status
from doorman.exceptions import DoormanError
from doorman.mission import simulate
from doorman.model import Model
from doorman.recording import Recording, Topic
from doorman.scenario import Scenario

AT_THE_LEAF = {"mission.start": "contact"}
MIRRORED = {
    "measurement": {
        "position": [1, -1, 1], "velocity": [1, -1, 1], "attitude": [-1, 1, -1], "body_rates": [-1, 1, -1],
        "arm_angles": [-1, 1, 1, 1], "arm_rates": [-1, 1, 1, 1],
    },
    "command": {"side_force": [1, -1]},
}  # fmt: skip
"""Signs in the image of y to -y. The shipped arm bends in the plane of symmetry; its first joint turns."""


@pytest.fixture(scope="module")
def model() -> Model:
    return Model(Scenario.load("push", AT_THE_LEAF))


@pytest.fixture(scope="module")
def folder(model: Model, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three seconds of a push that begins on the leaf, in still air."""
    folder = tmp_path_factory.mktemp("push")
    simulate(model, 3.0, seed=1, path=folder / "recording.mcap")
    return folder


@pytest.fixture(scope="module")
def recording(folder: Path) -> Recording:
    return Recording.load(folder / "recording.mcap")


@pytest.fixture(scope="module")
def found(recording: Recording, model: Model) -> LeafReplay:
    return replay_leaf(recording, model)


def with_topics(recording: Recording, **topics: Topic | None) -> Recording:
    return Recording(
        {name: topic for name, topic in ({**recording} | topics).items() if topic is not None}, recording.header,
        attachments=recording.attachments,
    )  # fmt: skip


def test_the_angle_and_the_touch_are_true(recording, found):
    truth = recording["truth"]
    error = found.joint - np.interp(found.time, truth.time, truth["door_angle"])
    assert np.ptp(truth["door_angle"]) > np.radians(3.0) and truth["touching"].mean() > 0.8
    assert np.degrees(np.abs(error)).max() < 1.0
    settled = found.time > 0.5
    assert found.touching[settled].min() > 0.5
    force = np.interp(found.time, truth.time, truth["tip_normal_force"])
    assert np.sqrt(np.mean((found.normal_force[:, 0] - force)[settled] ** 2)) < 0.5 * force[settled].mean()
    assert 2.0 < found.mean_nis < 4.5
    assert not found.slips[found.time > 1.0].any()
    assert np.isfinite(found.log_likelihood) and np.isfinite(found.deviations).all()


def test_what_is_replayed_is_what_was_flown_to_the_bit(recording, found):
    flown = recording["estimate"]
    at = np.searchsorted(flown.time, found.time - 1e-9)
    np.testing.assert_array_equal(found.joint, flown["state"][at, 3])
    np.testing.assert_array_equal(found.normal_force[:, 0], flown["normal_force"][at])


def test_a_door_on_the_left_is_estimated_as_its_image(recording, found):
    image = with_topics(recording, **{
        name: Topic(name, recording[name].time, {
            field: values * np.array(signs[field]) if field in signs else values
            for field, values in recording[name].items()
        })
        for name, signs in MIRRORED.items()
    })  # fmt: skip
    left = replay_leaf(image, Model(Scenario.load("push_left", AT_THE_LEAF)))
    np.testing.assert_allclose(left.joint, found.joint, atol=1e-6)
    np.testing.assert_allclose(left.normal_force, found.normal_force, atol=1e-4)
    np.testing.assert_allclose(left.probabilities, found.probabilities, atol=1e-5)
    assert left.log_likelihood == pytest.approx(found.log_likelihood, abs=1e-3)


@pytest.mark.parametrize("urdf", ["hexarotor_arm", "hexarotor_arm_with_mass"])
def test_a_grip_from_the_start_holds_the_leaf(urdf):
    model = Model(Scenario.load("paper", {"vehicle.urdf": urdf, **AT_THE_LEAF}))
    held = simulate(model, 3.0, seed=1)
    found = replay_leaf(held, model)
    error = found.joint - np.interp(found.time, held["truth"].time, held["truth"]["door_angle"])
    assert np.ptp(held["truth"]["door_angle"]) > np.radians(1.5)
    assert np.degrees(np.abs(error)).max() < 1.0
    assert found.probabilities[-1, -3:].sum() > 0.99 and found.hypotheses[-3:] == ("gripped", "holding", "thrown")
    assert 2.0 < found.mean_nis < 4.5


def test_another_number_changes_what_is_believed(recording, model, found):
    doubted = replay_leaf(recording, model, {"noise.wind": 3.0})
    winds = [part(one.deviations[-1], "wind")[:2] for one in (doubted, found)]
    assert (winds[0] > 2.0 * winds[1]).all()
    assert replay_leaf(recording, model, {"sensor.pose": 5e-3}).mean_nis < 0.5 * found.mean_nis


def test_the_command_prints_figures_and_draws(folder, found, tmp_path):
    ran = run("estimate", str(folder), "--out", str(tmp_path / "new" / "folder"), "--json")
    assert ran.exit_code == 0, ran.output
    figures = json.loads(ran.stdout)
    assert figures["log_likelihood"] == round(found.log_likelihood, 1)
    assert figures["mean_nis_of_3"] == round(found.mean_nis, 3)
    assert 0.0 < figures["mean_nees_of_2"] < 10.0
    picture = Path(figures["picture"])
    assert picture == tmp_path / "new" / "folder" / "estimate.png"
    assert picture.stat().st_size > 10_000


def test_bad_input_is_one_line_and_status_2(folder, tmp_path):
    assert_bad_input(run("estimate", str(tmp_path / "none")), "no such run")
    for change, *words in (
        ("noise.wnd=1", "noise.wnd", "noise.wind", "switch.near"),
        ("vehicle.mass=2", "vehicle.mass", "noise.wind"),
        ("noise.wind", "--set", "NAME=NUMBER"),
        ("noise.wind=much", "--set", "NAME=NUMBER"),
        ("noise.wind=nan", "noise.wind", "above 0"),
        ("noise.wind=-1", "noise.wind", "above 0"),
    ):
        assert_bad_input(run("estimate", str(folder), "--set", change, "--out", str(tmp_path)), *words)
    assert not list(tmp_path.iterdir())


def test_a_recording_that_lacks_a_topic_or_poses_is_refused(recording, model):
    for topic in ("measurement", "command", "mission"):
        with pytest.raises(DoormanError, match=f"no {topic}"):
            replay_leaf(with_topics(recording, **{topic: None}), model)
    measured = recording["measurement"]
    few = Topic("measurement", measured.time[:3], {name: values[:3] for name, values in measured.items()})
    with pytest.raises(DoormanError, match="too few poses"):
        replay_leaf(with_topics(recording, measurement=few), model)


def test_lost_poses_and_a_jump_of_the_clock_are_gone_through(recording, model, found):
    measured = recording["measurement"]
    position, time = measured["position"].copy(), measured.time.copy()
    position[200:210], pose_time = np.nan, measured["pose_time"].copy()
    time[500:] += 5.0
    pose_time[500:] += 5.0
    broken = Topic("measurement", time, {**measured, "position": position, "pose_time": pose_time})
    replayed = replay_leaf(with_topics(recording, measurement=broken), model)
    assert (replayed.statuses == Status.LOST).sum() == 1 and np.isfinite(replayed.mean).all()
    assert len(replayed.time) < len(found.time) and np.isfinite(replayed.log_likelihood)


def with_readings(recording: Recording, off: float = 0.0, deviation: float = 0.002) -> Recording:
    """The same with a sensor of the leaf, 100 readings a second, 20 ms late."""
    truth = recording["truth"]
    when = np.arange(0.02, truth.time[-1] - 0.03, 0.01)
    noise = deviation * np.random.default_rng(0).standard_normal(len(when))
    angle = np.interp(when, truth.time, truth["door_angle"]) + noise + off
    columns = {
        "joint": angle, "door_angle": angle, "leaf_time": when, "deviation": np.full(len(when), deviation),
        "believed": np.ones(len(when)),
    }  # fmt: skip
    return with_topics(recording, door_sensor=Topic("door_sensor", when + 0.02, columns))


def test_a_measured_leaf_is_one_more_row(recording, found, model):
    truth, measured = recording["truth"], replay_leaf(with_readings(recording), model)
    errors = [
        np.abs(one.joint - np.interp(one.time, truth.time, truth["door_angle"]))[100:] for one in (found, measured)
    ]
    assert np.degrees(errors[1].max()) < 0.3 and errors[1].max() < errors[0].max() + 1e-4
    assert part(measured.deviations[-1], "joint") < part(found.deviations[-1], "joint")


def test_readings_that_no_hypothesis_explains_are_refused(recording, found, model):
    lying = replay_leaf(with_readings(recording, off=np.radians(-25.0)), model)
    late = found.time > 1.0
    assert np.degrees(np.abs(lying.joint - found.joint)[late].max()) < 1.0
