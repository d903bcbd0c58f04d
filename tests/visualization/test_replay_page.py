"""Replay page: self-contained, and what it animates is what was recorded."""

import importlib.util
import json
import math
from html.parser import HTMLParser

import numpy as np
import pinocchio
import pytest
from simple_flight import fly
from urdf_variants import DOOR, VEHICLE, write_arm_of

from doorman.exceptions import DoormanError, RecordingError
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recorder, Recording
from doorman.scenario import Scenario
from doorman.visualization import constraints_and_forces_figure, replay_page, states_figure
from doorman.visualization.scene.drawing import Drawing
from doorman.visualization.scene.moments import Moment
from doorman.visualization.scene.shapes import visual_shapes


class Page(HTMLParser):
    """Tags of a page, the texts of its scripts, its title, and the flight in it."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.scripts, self.title = [], [], ""
        self.feed(text)
        (script,) = [script for script in self.scripts if script.startswith("const flight = ")]
        flight = json.loads(script.strip().removeprefix("const flight = ").removesuffix(";"))
        self.scene, self.frames, self.live = flight["scene"], flight["frames"], flight["live"]

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))
        if tag == "script":
            self.scripts.append("")

    def handle_data(self, data):
        if self.tags and self.tags[-1][0] == "script":
            self.scripts[-1] += data
        elif self.tags and self.tags[-1][0] == "title" and data.strip():
            self.title = data

    def commands(self, kind):
        return {command["path"]: command for command in self.scene["commands"] if command["type"] == kind}

    def column(self, name):
        return np.array([frame[name] for frame in self.frames])

    def placements(self, path):
        """Placement in every frame, shape (m, 4, 4)."""
        if path not in self.scene["nodes"]:
            matrix = np.array(self.commands("set_transform")[f"/{path}"]["matrix"])
            return matrix.reshape(1, 4, 4).transpose(0, 2, 1)
        poses = np.array([frame["poses"][self.scene["nodes"].index(path)] for frame in self.frames])
        placements = np.tile(np.eye(4), (len(poses), 1, 1))
        placements[:, :3, 3] = poses[:, :3]
        placements[:, :3, :3] = [pinocchio.Quaternion(*q[[3, 0, 1, 2]]).normalized().matrix() for q in poses[:, 3:]]
        return placements


@pytest.fixture(scope="module")
def page(flight, model, tmp_path_factory):
    path = replay_page(flight, model, tmp_path_factory.mktemp("replay") / "replay.html")
    return Page(path.read_text(encoding="utf-8"))


def test_page_needs_nothing_but_itself(page):
    assert [name for tag, attributes in page.tags for name in attributes if name in ("src", "href", "srcset")] == []
    assert not {"link", "iframe", "img", "object", "embed"} & {tag for tag, _ in page.tags}
    viewer, data, ours = page.scripts
    assert len(viewer) > 500_000 and "MeshCat" in viewer
    assert page.live == "" and "http" not in data + ours
    assert page.title == "doorman: paper"


def test_frames_run_through_the_whole_flight(page, flight):
    flown = flight["truth"].time[-1] - flight["truth"].time[0]
    np.testing.assert_allclose(page.column("time"), np.arange(int(flown * 30) + 1) / 30, atol=1e-4)
    links = ("tip", "servo_1", "servo_2", "servo_3", "servo_4")
    moved = {"scene/vehicle", "scene/door/leaf", *(f"scene/vehicle/{link}" for link in links)}
    assert set(page.scene["nodes"]) == moved
    assert all(len(frame["poses"]) == len(page.scene["nodes"]) for frame in page.frames)


def test_tip_touches_the_leaf_in_every_frame(page, model):
    """From the page alone: the drawn tip, in the drawn leaf's frame, stays at the contact point of its surface."""
    tip = (page.placements("scene/vehicle") @ page.placements("scene/vehicle/tip"))[:, :, 3]
    np.testing.assert_allclose(tip[:, :3], page.column("tip"), atol=2e-4)
    leaf = page.placements("scene/door/leaf")
    in_leaf = np.einsum("mij,mj->mi", np.linalg.inv(leaf), tip)[:, :3]
    contact = [model.scenario.contact.distance_from_hinge, 0.0, model.scenario.contact.height]
    np.testing.assert_allclose(in_leaf, np.tile(contact, (len(tip), 1)), atol=2e-3)  # straight between two records


def test_vehicle_and_leaf_are_where_they_were_recorded(page, flight):
    truth = flight["truth"]
    placements = page.placements("scene/vehicle")
    for frame in (0, 45, 100):
        for i in range(3):
            there = np.interp(frame / 30, truth.time, truth["position"][:, i])
            assert placements[frame, i, 3] == pytest.approx(there, abs=1e-4)
    leaf = page.placements("scene/door/leaf")
    shown = np.unwrap(np.arctan2(leaf[:, 1, 0], leaf[:, 0, 0]))
    angles = page.column("door_angle")
    np.testing.assert_allclose(np.degrees(shown), angles, atol=0.02)
    assert angles[0] == pytest.approx(90.0) and angles[-1] < 25.0
    assert page.scene["goal"] == pytest.approx(20.0)


def test_leaf_and_frame_are_drawn_where_they_truly_stand(model):
    yaw, angle = 0.1, 1.2
    keys = {"simulation.door_offset": [0.05, 0.0, 0.0], "simulation.door_yaw": yaw, "simulation.door_face_offset": 0.04}
    drawing = Drawing(Model(model.scenario.replace(keys)))
    scene = drawing.scene()
    moment = Moment(0.0, np.array([-1.0, 0.7, 1.2]), np.zeros(3), angle, model.goal_arm, None, None, "", "")
    leaf = drawing.frame(moment)["poses"][scene["nodes"].index("scene/door/leaf")]
    turn = rotation_body_to_world([0.0, 0.0, angle + yaw])
    np.testing.assert_allclose(leaf[:3], [0.05, 0.0, 0.4] + turn @ [0.0, 0.04, 0.0], atol=1e-4)
    np.testing.assert_allclose(leaf[3:], [0.0, 0.0, np.sin((angle + yaw) / 2), np.cos((angle + yaw) / 2)], atol=1e-5)
    (frame,) = [one for one in scene["commands"] if one.get("path") == "/scene/door/frame" and "matrix" in one]
    matrix = np.array(frame["matrix"]).reshape(4, 4).T
    np.testing.assert_allclose(matrix[:3, :3], rotation_body_to_world([0.0, 0.0, yaw]), atol=1e-6)


def test_clearances_are_the_constraints_where_the_tip_touches(page, flight, model):
    truth = flight["truth"]
    states = np.column_stack([truth["attitude"], truth["door_angle"], truth["door_rate"], truth["arm_angles"]])
    h = model.constraints_along(states)
    left = -np.column_stack([h[:, 3], h[:, 5], h[:, 4], h[:, :3].max(axis=1)])
    for i, surface in enumerate(page.scene["surfaces"]):
        there = np.interp(page.column("time"), truth.time, left[:, i])
        np.testing.assert_allclose(page.column("clearances")[:, i], there, atol=2e-3, err_msg=surface["name"])
    assert np.ptp(page.column("clearances"), axis=0).min() > 0.005


def test_the_ribbon_is_the_plan(page, flight, model):
    plan = flight["plan"]
    for frame in (0, 60):
        ribbon = np.array(page.frames[frame]["ribbon"])
        newest = np.searchsorted(plan.time, frame / 30 + 1e-9, side="right") - 1
        for row, state in ((ribbon[0], plan["states"][newest][0]), (ribbon[-1], plan["states"][newest][-1])):
            middle = 0.5 * (row[:3] + row[3:])
            planned = model.coupling.vehicle_position(state[:3], state[3], state[5:])
            np.testing.assert_allclose(middle, planned, atol=2e-3)
            assert np.linalg.norm(row[3:] - row[:3]) == pytest.approx(0.05, abs=2e-3)
    outdated = [frame["ribbon"] for frame in page.frames if 0.155 < frame["time"] % 0.2 < 0.195]
    assert len(outdated) > 10 and outdated == [None] * len(outdated)


def test_phases_and_forces_are_told(page, flight):
    assert [page.frames[k]["phase"] for k in (0, 11, 13, len(page.frames) - 1)] == ["touch", "touch", "open", "open"]
    assert page.frames[0]["reason"] == "as planned"
    forces = page.column("force")
    np.testing.assert_allclose(forces[30], flight["truth"]["tip_force"][50], atol=2e-3)


def test_every_visual_shape_is_there_with_its_colour_and_axis(page):
    objects, transforms = page.commands("set_object"), page.commands("set_transform")
    kinds = {path: command["object"]["geometries"][0]["type"] for path, command in objects.items()}
    assert sum("/shape_" in path for path in objects) == len(visual_shapes(VEHICLE)) + len(visual_shapes(DOOR))
    assert sum("/turning/" in path and kinds[path] == "BoxGeometry" for path in objects) == 6
    (disc,) = [path for path in objects if path.endswith("/disc")]
    material = objects[disc]["object"]["materials"][0]
    assert material["transparent"] and 0.0 < material["opacity"] < 1.0
    # the body's plate is a URDF cylinder about z; the viewer's stand along y
    plate = next(
        path for path in objects if "/base_link/" in path and kinds[path] == "CylinderGeometry" and path != disc
    )
    matrix = np.reshape(transforms[plate]["matrix"], (4, 4)).T
    np.testing.assert_allclose(matrix[:3, 1], [0.0, 0.0, 1.0], atol=1e-9)
    np.testing.assert_allclose(matrix[:3, 3], [0.0, 0.0, 0.012], atol=1e-9)
    assert objects[plate]["object"]["materials"][0]["color"] == 0x26292E  # 0.15 0.16 0.18
    assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1.0)


def test_rotors_turn_in_their_sense(page, model):
    assert [direction for _, direction in page.scene["rotors"]] == [rotor.direction for rotor in model.vehicle.rotors]
    parents = {path.rpartition("/")[0].strip("/") for path in page.commands("set_object")}
    assert {path for path, _ in page.scene["rotors"]} <= parents


def test_measured_flight_is_replayed_from_measurement_and_estimate(model, tmp_path):
    recording = fly(model, 1.0, with_truth=False)
    page = Page(replay_page(recording, model, tmp_path / "replay.html").read_text(encoding="utf-8"))
    np.testing.assert_allclose(
        page.placements("scene/vehicle")[0, :3, 3], recording["measurement"]["position"][0], atol=1e-4
    )
    estimate = recording["estimate"]
    there = np.interp(page.column("time"), estimate.time, estimate["state"][:, 3])
    np.testing.assert_allclose(page.column("door_angle"), np.degrees(there), atol=0.01)
    assert page.frames[0]["force"] is None


@pytest.mark.parametrize("joints", [1, 2, pytest.param(7, marks=pytest.mark.slow)])
def test_arms_of_any_number_of_joints(tmp_path, joints):
    urdf = write_arm_of(tmp_path / "arm.urdf", joints)
    model = Model(Scenario.load("paper", {"vehicle.urdf": str(urdf), "start.arm": [0.1] * joints, "goal.arm": [0.2] * joints,
                                          "planner.weights": {}}))  # fmt: skip
    flown = fly(model, 0.5)
    page = Page(replay_page(flown, model, tmp_path / "replay.html").read_text(encoding="utf-8"))
    assert "scene/vehicle" in page.scene["nodes"] and page.frames[-1]["door_angle"] < 90.0
    shown = [axes for axes in states_figure(flown, model).axes if axes.axison]
    measured = [{line.get_label() for line in axes.lines} >= {"measured"} for axes in shown]
    assert measured == [True] * (5 + joints)
    assert shown[-1].get_ylabel() == f"$\\eta_{{{joints}}}$ [deg]" and shown[-1].get_xlabel() == "time [s]"
    figure, names = constraints_and_forces_figure(flown, model), model.constraint_names
    for axes, some in zip(figure.axes[:2], (names[:-3], names[-3:]), strict=True):
        assert {line.get_label() for line in axes.lines} >= set(some)


HOSTILE = "</script><script>alert(1)</script><!-- <script> $title ${flight} \u2028 &amp; </ScRiPt >"


def test_name_and_messages_cannot_break_the_page(flight, model, tmp_path):
    recorder = Recorder(None, {})
    recorder.write("mission", 0.0, {"state": HOSTILE, "message": HOSTILE})
    hostile = Recording(dict(flight) | dict(recorder.recording()), {"name": HOSTILE})
    page = Page(replay_page(hostile, model, tmp_path / "replay.html").read_text(encoding="utf-8"))
    clean = Page(replay_page(flight, model, tmp_path / "clean.html").read_text(encoding="utf-8"))
    assert len(page.scripts) == len(clean.scripts) == 3
    assert [page.scripts[k] for k in (0, 2)] == [clean.scripts[k] for k in (0, 2)]
    assert "<" not in page.scripts[1]  # nothing in the data that a parser of HTML looks at
    assert {frame["reason"] for frame in page.frames} == {frame["phase"] for frame in page.frames} == {HOSTILE}


def test_times_that_are_not_finite_are_left_out(model, flight, tmp_path):
    recorder = Recorder(None, {})
    truth = flight["truth"]
    names = ("position", "attitude", "door_angle", "arm_angles")
    for k, moment in enumerate(truth.time[:100]):
        fields = {name: truth[name][k] * (math.nan if k in (0, 50, 51) else 1.0) for name in names}
        recorder.write("truth", moment, fields)
    page = Page(replay_page(recorder.recording(), model, tmp_path / "replay.html").read_text(encoding="utf-8"))
    assert page.frames[0]["time"] == 0.02
    assert np.isfinite(page.placements("scene/vehicle")).all()
    recorder = Recorder(None, {})
    recorder.write("truth", 0.0, {name: truth[name][0] * math.nan for name in names})
    for nothing, words in ((recorder.recording(), "finite"), (Recording({}, {}), "truth")):
        with pytest.raises(RecordingError, match=words):
            replay_page(nothing, model, tmp_path / "replay.html")


def test_a_single_record_is_a_still_picture(model, flight, tmp_path):
    recorder = Recorder(None, {})
    recorder.write("truth", 0.0, {name: flight["truth"][name][0] for name in flight["truth"]})
    page = Page(replay_page(recorder.recording(), model, tmp_path / "replay.html").read_text(encoding="utf-8"))
    assert len(page.frames) == 1 and page.frames[0]["phase"] == ""


def test_missing_meshcat_says_what_to_install(flight, model, tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(DoormanError, match=r"pip install -e '\.\[viz\]'"):
        replay_page(flight, model, tmp_path / "replay.html")
    assert not (tmp_path / "replay.html").exists()
