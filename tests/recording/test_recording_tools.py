"""`doorman export`, `doorman plot` and `doorman replay` on a short recorded flight."""

from __future__ import annotations

import csv
import json
import os
import re
import shutil
import sys
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest
from made_meshes import TETRAHEDRON, stl
from pyarrow import parquet
from typer.testing import CliRunner, Result

from doorman.cli import app
from doorman.cli.recordings.replayed import replay_plans
from doorman.control.wanted import Wanted
from doorman.exceptions import DoormanError, RecordingError
from doorman.flown import carried_files, recorded_header, recorded_scenario
from doorman.kinematics.urdf.mesh_files import mesh_file
from doorman.mission import PlanSchedule, simulate
from doorman.model import Model
from doorman.planning.hinge import Hinge
from doorman.planning.planner import Planner
from doorman.recording import Recorder, Recording, Topic
from doorman.recording.export import export
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

CONTACT = {"mission.start": "contact"}


def run(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(Scenario.load("paper", CONTACT))


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory, planner: Planner) -> Path:
    folder = tmp_path_factory.mktemp("flight")
    simulate(planner.model, 1.2, path=folder / "recording.mcap", planner=planner)
    return folder


@pytest.fixture(scope="module")
def recording(flight: Path) -> Recording:
    return Recording.load(flight / "recording.mcap")


def changed(recording: Recording, path: Path, change: Callable[[str, int, dict[str, Any]], dict[str, Any]]) -> Path:
    """Copy of a recording whose messages went through `change`."""
    with Recorder(path, recording.header) as recorder:
        for name, topic in recording.items():
            for k, time in enumerate(topic.time):
                message = {field: value.item() if np.ndim(value := topic[field][k]) == 0 else value for field in topic}
                recorder.write(name, float(time), change(name, k, message))
    return path


# ---------------------------------------------------------------- export


def test_csv_keeps_every_bit(flight, recording):
    result = run("export", flight, "--csv", "--json")
    assert result.exit_code == 0, result.output
    topics = json.loads(result.stdout)["topics"]
    assert set(topics) == {"header", *recording}
    assert json.loads(Path(topics["header"]["file"]).read_text(encoding="utf-8")) == recording.header
    for name, topic in recording.items():
        with Path(topics[name]["file"]).open(newline="", encoding="utf-8") as stream:
            table = list(csv.DictReader(stream))
        assert len(table) == topics[name]["messages"] == len(topic.time)
        assert [float(row["time"]) for row in table] == topic.time.tolist()
        expected = sum(int(np.prod(topic[field].shape[1:])) for field in topic) + 1
        assert len(table[0]) == expected
    with (flight / "recording-csv" / "plan.csv").open(newline="", encoding="utf-8") as stream:
        plans = list(csv.DictReader(stream))
    assert [float(row["states_50_8"]) for row in plans] == recording["plan"]["states"][:, 50, 8].tolist()
    assert [row["status"] for row in plans] == recording["plan"]["status"].tolist()
    assert [float(row["cost"]) for row in plans] == recording["plan"]["cost"].tolist()


def test_a_data_frame_is_what_csv_says(flight, recording):
    folder = Path(json.loads(run("export", flight, "--csv", "--json").stdout)["topics"]["header"]["file"]).parent
    for name in recording:
        frame, table = recording.to_pandas(name), pandas.read_csv(folder / f"{name}.csv", keep_default_na=False)
        assert frame.index.name == "time" and list(table.columns) == ["time", *frame.columns]
        np.testing.assert_array_equal(frame.index, recording[name].time)
    truth = recording.to_pandas("truth")
    np.testing.assert_array_equal(truth["position_z"], recording["truth"]["position"][:, 2])
    np.testing.assert_array_equal(truth["attitude_yaw"], recording["truth"]["attitude"][:, 2])
    np.testing.assert_array_equal(truth["arm_angles_3"], recording["truth"]["arm_angles"][:, 3])


@pytest.mark.parametrize("reader", [pandas.DataFrame, np.asarray, np.array])
def test_a_topic_is_no_array_of_its_names(recording, reader):
    for thing in (recording, recording["truth"]):
        with pytest.raises(RecordingError, match="to_pandas"):
            reader(thing)


def test_a_data_frame_without_pandas_names_the_extra(recording, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(DoormanError, match=r"pip install -e '.\[pandas\]'"):
        recording.to_pandas("truth")


def test_fields_of_one_name_keep_their_columns():
    fields = {"position": np.ones((1, 3)), "position_x": np.zeros(1)}
    assert list(Topic("log", np.zeros(1), fields).to_pandas().columns) == [
        "position[x]", "position[y]", "position[z]", "position_x"
    ]  # fmt: skip


def test_parquet_keeps_every_bit_and_the_shapes(flight, recording, tmp_path):
    result = run("export", flight / "recording.mcap", "--parquet", "--out", tmp_path / "tables")
    assert result.exit_code == 0, result.output
    written = {path.name for path in (tmp_path / "tables").iterdir()}
    assert written == {"header.json", *(f"{name}.parquet" for name in recording)}
    for name, topic in recording.items():
        table = parquet.read_table(tmp_path / "tables" / f"{name}.parquet")
        assert table.column_names == ["time", *topic]
        for field in topic:
            np.testing.assert_array_equal(np.array(table[field].to_pylist()), topic[field], strict=True)
    assert str(parquet.read_schema(tmp_path / "tables" / "plan.parquet").field("states").type).count("[") == 2


def test_one_format_at_a_time(flight):
    result = run("export", flight, "--csv", "--parquet")
    assert result.exit_code == 2
    assert "one format at a time" in result.stderr


def test_parquet_without_pyarrow_names_the_extra(flight, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    result = run("export", flight, "--parquet", "--out", tmp_path / "tables")
    assert result.exit_code == 2
    assert "pip install -e '.[campaign]'" in result.stderr
    assert not (tmp_path / "tables").exists()


def test_names_of_topics_do_not_leave_the_folder(tmp_path):
    with Recorder(None, {}) as recorder:
        recorder.write("../up", 0.0, {"value": float("nan"), "flags": [True, False], "words": ["a", "b,c"]})
        files = export(recorder.recording(), tmp_path / "tables", "csv")
        assert files["../up"].parent == tmp_path / "tables"
        assert files["../up"].read_text() == 'time,value,flags_0,flags_1,words_0,words_1\n0.0,nan,True,False,a,"b,c"\n'
        recorder.write(".._up", 0.0, {"value": 1.0})
        recorder.write("___up", 0.0, {"value": 1.0})
        with pytest.raises(RecordingError, match="same file"):
            export(recorder.recording(), tmp_path, "csv")
    with pytest.raises(DoormanError, match="no such format"):
        export(recorder.recording(), tmp_path, "xlsx")  # type: ignore[arg-type]


def test_no_cell_is_taken_for_a_formula(tmp_path):
    formulas = ["=1+1", "+1", "-1+1", "@SUM(A1)", "\t=1", "\r=1", "=cmd|' /C calc'!A0", "-", "＝1", "-inf|x"]
    harmless = ["", "a=1", "-1.5", "-2e-07", "-.5", "-inf", "'x", "paper", " 1", "α"]
    with Recorder(None, {}) as recorder:
        for k, word in enumerate([*formulas, *harmless]):
            recorder.write("event", k, {"message": word, "words": [word, "x"], "=2+2": -1.0, "amount": -0.5 - k})
        files = export(recorder.recording(), tmp_path, "csv")
    with files["event"].open(newline="", encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["message"] for row in rows] == [*(f"'{word}" for word in formulas), *harmless]
    assert [row["words_0"] for row in rows] == [row["message"] for row in rows]
    assert [float(row["amount"]) for row in rows] == [-0.5 - k for k in range(20)]
    assert list(rows[0])[3:5] == ["words_1", "'=2+2"]


@pytest.mark.parametrize("command", ["estimate", "export", "plot", "replay", "view"])
def test_a_run_that_is_not_there_is_bad_input(command, tmp_path):
    for given, words in ((tmp_path / "none", "no such run"), (tmp_path, "not the folder of one run")):
        result = run(command, given)
        assert result.exit_code == 2
        assert words in result.stderr


# ---------------------------------------------------------------- plot


def test_plot_makes_the_figures_again(flight, tmp_path):
    figures = ("states", "constraints", "swing", "planner_time")
    names = {"replay.html", *(f"{name}.{kind}" for name in figures for kind in ("png", "pdf"))}
    result = run("plot", flight, "--out", tmp_path / "figures", "--json")
    assert result.exit_code == 0, result.output
    files = [Path(file) for file in json.loads(result.stdout)["files"]]
    assert {file.name for file in files} == names
    assert all(file.parent == tmp_path / "figures" and file.stat().st_size > 10_000 for file in files)


def test_urdfs_are_found_where_the_scenario_beside_the_recording_says(flight, recording, tmp_path):
    header = json.loads(json.dumps(recording.header))
    header["scenario"]["vehicle"]["urdf"] = "somewhere/else.urdf"
    with Recorder(tmp_path / "recording.mcap", header) as recorder:
        recorder.write("estimate", 0.0, {"state": recording["estimate"]["state"][0]})
    assert run("plot", tmp_path).exit_code == 2
    (tmp_path / "scenario.toml").write_text('[vehicle]\nurdf = "hexarotor_arm"\n')
    result = run("replay", tmp_path)
    assert "has no plans" in result.stderr  # the vehicle was found


def test_keys_of_another_version_are_a_warning(recording, tmp_path):
    header = json.loads(json.dumps(recording.header))
    header["scenario"]["planner"]["crystal_ball"] = True
    header["scenario"]["tea"] = {"sugar": 2}
    header["version"] = "9.9.9"
    with Recorder(tmp_path / "recording.mcap", header, attachments=recording.attachments) as recorder:
        recorder.write("truth", 0.0, {name: recording["truth"][name][0] for name in recording["truth"]})
    result = run("view", tmp_path, "--out", tmp_path / "page.html")
    assert result.exit_code == 0, result.output
    assert "Warning" in result.stderr and "planner.crystal_ball" in result.stderr and "tea" in result.stderr
    with pytest.warns(UserWarning, match="crystal_ball"):
        assert recorded_scenario(Recording.load(tmp_path)).planner == Scenario.load("paper", CONTACT).planner


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda header: header.clear(), "which scenario"),
        (lambda header: header.update(scenario=[1, 2]), "which scenario"),
        (lambda header: header["scenario"].update(planner=3), "header.scenario.planner"),
        (lambda header: header["scenario"]["planner"].update(rate=-1.0), "header.scenario.planner.rate"),
        (lambda header: header["scenario"].update(vehicle={"urdf": "/nowhere/vehicle.urdf"}), "vehicle.urdf"),
    ],
)
def test_a_recording_without_a_usable_scenario_is_bad_input(recording, tmp_path, change, words):
    header = json.loads(json.dumps(recording.header))
    change(header)
    with Recorder(tmp_path / "recording.mcap", header) as recorder:
        recorder.write("estimate", 0.0, {"state": [0.0]})
    result = run("plot", tmp_path)
    assert result.exit_code == 2
    assert words in result.stderr and result.stderr.count("\n") == 1


def test_a_damaged_recording_is_shown_as_far_as_it_goes(flight, recording, tmp_path):
    data = bytearray((flight / "recording.mcap").read_bytes())
    data[len(data) // 2] ^= 0xFF
    (tmp_path / "recording.mcap").write_bytes(data)
    result = run("export", tmp_path)
    assert result.exit_code == 0, result.output
    assert "damaged: 1 chunk" in result.stdout
    result = run("export", tmp_path, "--json")
    assert json.loads(result.stdout)["complete"] is False and "damaged: 1 chunk" in result.stderr


# ---------------------------------------------------------------- recordings that travel


def test_a_recording_is_viewed_where_its_urdfs_and_meshes_are_not(recording, tmp_path):
    """The files of the flight are gone; header and attachments are all that is left."""
    home = tmp_path / "home"
    (home / "shapes").mkdir(parents=True)
    for name in ("leaf.stl", "a b&c.stl"):
        (home / "shapes" / name).write_bytes(stl(TETRAHEDRON))
    door = (urdf_directory() / "hinged_door.urdf").read_text(encoding="utf-8")
    mesh = '<visual><geometry><mesh filename="{}"/></geometry></visual>'
    files = "shapes/leaf.stl", "package://home/shapes/leaf.stl", "shapes/a b&amp;c.stl", "no.stl"
    meshes = "".join(map(mesh.format, files))
    (home / "my_door.urdf").write_text(door.replace("</link>", f"{meshes}</link>", 1), encoding="utf-8")
    (home / "task.toml").write_text('[door]\nurdf = "my_door.urdf"\ndamping = 0.9\n[vehicle]\nradius = 0.4\n')
    scenario = Scenario.load(home / "task.toml")
    carried = carried_files(scenario)
    path = tmp_path / "far" / "recording.mcap"
    with Recorder(path, recorded_header(scenario), attachments=carried) as recorder:
        recorder.write("truth", 0.0, {name: recording["truth"][name][0] for name in recording["truth"]})
    shutil.rmtree(home)
    assert len(carried) == 4 and carried["vehicle.urdf"] == (urdf_directory() / "hexarotor_arm.urdf").read_bytes()
    again = recorded_scenario(Recording.load(path.parent))
    assert again.door.damping == 0.9 and again.vehicle.radius == 0.4
    assert mesh_file(again.door_urdf, "door-0-leaf.stl") is not None
    filenames = re.findall('filename="([^"]+)"', again.door_urdf.read_text())
    assert filenames == ["door-0-leaf.stl", "door-0-leaf.stl", "door-1-a_b_c.stl", "no.stl"]
    assert Model(again).door.mass == Model(Scenario.load("paper")).door.mass
    result = run("view", path.parent, "--json", "--out", tmp_path / "page.html")
    assert result.exit_code == 0, result.output


def test_names_of_attachments_do_not_lead_out_of_their_folder(recording, tmp_path):
    hostile = {"../../evil.urdf": b"evil", f"{tmp_path}/absolute": b"evil", "..": b"evil", "a/b": b"evil"}
    files = dict(recording.attachments) | hostile
    there = recorded_scenario(Recording({}, recording.header, attachments=files)).vehicle_urdf.parent
    assert {path.name for path in there.iterdir()} == {"vehicle.urdf", "door.urdf"}
    assert not (tmp_path / "absolute").exists() and not list(there.parent.parent.glob("*.urdf"))


def test_the_summary_of_a_loaded_recording_is_computed_when_asked_for(flight, recording, planner):
    flown = simulate(planner.model, 1.0, planner=planner)
    assert set(recording.summary) == set(flown.summary)
    assert Recording.load(flight).summary == recording.summary
    assert recording.summary["duration_s"] == recording["truth"].time[-1]
    with pytest.raises(RecordingError, match="lacks the topic 'truth'"):
        _ = Recording({"plan": recording["plan"]}, recording.header).summary


# ---------------------------------------------------------------- the newest run


def test_the_newest_run_is_taken_by_default_and_named(flight, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for command in ("view", "export", "plot", "replay", "estimate"):
        result = run(command)
        assert result.exit_code == 2 and "no run there yet" in result.stderr
    data = (flight / "recording.mcap").read_bytes()
    for age, name in enumerate(("paper-2", "paper-9/recording", "fly-1/flight", "paper-3/recording")):
        path = Path("runs") / f"{name}.mcap"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
        os.utime(path, (1e9 - age, 1e9 - age))
    Path("runs/campaign-push").mkdir()
    for expected in ("runs/paper-2.mcap", "runs/paper-9/recording.mcap", "runs/fly-1/flight.mcap"):
        result = run("export", "--json")
        assert result.exit_code == 0, result.output
        assert f"The newest run: {expected}" in result.stderr
        header = json.loads(result.stdout)["topics"]["header"]["file"]
        assert Path(header).parent.parent == Path(expected).parent
        Path(expected).unlink()
    assert "runs/paper-3" in run("view", "--out", "page.html").stderr
    assert "newest" not in run("export", "runs/paper-3").stderr


# ---------------------------------------------------------------- view


def use_browser(folder, monkeypatch):
    """A program as browser that writes the address into a file."""
    program = folder / "browser.sh"
    program.write_text(f'#!/bin/sh\necho "$1" > {folder}/opened\n')
    program.chmod(0o755)
    monkeypatch.setenv("BROWSER", f"{program} %s")
    monkeypatch.setattr(webbrowser, "_tryorder", None)  # it reads the environment once


def test_view_writes_the_page_and_opens_it(flight, tmp_path, monkeypatch):
    use_browser(tmp_path, monkeypatch)
    result = run("view", flight, "--json")
    assert result.exit_code == 0, result.output
    answer = json.loads(result.stdout)
    assert answer == {"complete": True, "file": str(flight / "replay.html"), "opened": True}
    assert "const flight = " in (flight / "replay.html").read_text(encoding="utf-8")
    assert (tmp_path / "opened").read_text().strip() == (flight / "replay.html").as_uri()


def test_view_writes_a_page_elsewhere_without_a_browser(flight, tmp_path, monkeypatch):
    use_browser(tmp_path, monkeypatch)
    result = run("view", flight, "--out", tmp_path / "page.html")
    assert result.exit_code == 0, result.output
    assert result.stdout.split() == [str(tmp_path / "page.html")]
    assert (tmp_path / "page.html").is_file() and not (tmp_path / "opened").exists()


# ---------------------------------------------------------------- replay


def test_every_plan_comes_out_the_same_to_the_bit(flight, recording):
    result = run("replay", flight, "--json")
    assert result.exit_code == 0, result.output
    plans = len(recording["plan"].time)
    assert plans >= 25
    counts = {"plans": plans, "cold": 1, "not_compared": 0}
    assert json.loads(result.stdout) == {"identical": True, **counts, "differences": []}


def test_changing_doors_and_cold_plans_are_replayed(planner):
    told, inertias = [0.0, -0.3, -0.31, 0.2, -1.0, -1.1], [5.3, 5.3, 6.0, 7.5, 7.5, 7.0]
    dampings = [0.0, 0.7, 0.6, 0.6, 0.2, 0.3]
    with Recorder(None, {}) as recorder:
        schedule = PlanSchedule(planner, 0, recorder)
        for k, (disturbance, inertia, damping) in enumerate(zip(told, inertias, dampings, strict=True)):
            if k == 3:
                schedule.forget()
            hinge = Hinge(0.0, disturbance, inertia, damping, 0.5 * damping)
            wanted = Wanted(planner.planning.start_state, hinge)
            schedule.update(schedule.period * k, lambda wanted=wanted: wanted)
        recording = recorder.recording()
    assert recording["plan"]["hinge"][:, 1:4].T.tolist() == [told, inertias, dampings]
    assert recording["plan"]["cold"].tolist() == [True, False, False, True, False, False]
    found = replay_plans(recording, planner)
    assert (found.plans, found.cold, found.identical, found.not_compared) == (6, 2, True, 0)


def of_plans(change: Callable[[int, dict[str, Any]], dict[str, Any]]) -> Callable[..., dict[str, Any]]:
    """A change of messages that is one of plans alone."""
    return lambda topic, k, message: message | change(k, message) if topic == "plan" else message


def test_plans_that_the_clock_cut_short_are_not_compared_up_to_the_next_cold_one(recording, planner, tmp_path):
    cut = of_plans(
        lambda k, plan: {"cut_short": k == 3, "cold": k in (0, 6), "cost": -1.0 if k in (4, 7) else plan["cost"]}
    )
    path = changed(recording, tmp_path / "changed.mcap", cut)
    found = replay_plans(Recording.load(path), planner)
    assert found.not_compared == 3
    numbers = [one.plan for one in found.differences]
    assert 7 in numbers and not {3, 4, 5} & set(numbers)
    assert "3 not compared" in run("replay", path).stdout


def test_the_last_bit_of_one_number_is_noticed(recording, tmp_path):
    def change(k: int, plan: dict[str, Any]) -> dict[str, Any]:
        nudged = [np.nextafter(plan["input"][0], np.inf), *plan["input"][1:]]
        return {3: {"input": nudged}, 5: {"status": "infeasible"}}.get(k, {})

    result = run("replay", changed(recording, tmp_path / "changed.mcap", of_plans(change)), "--json")
    assert result.exit_code == 1, result.output
    found = json.loads(result.stdout)
    assert found["identical"] is False
    assert [(one["plan"], list(one["fields"])) for one in found["differences"]] == [(3, ["input"]), (5, ["status"])]
    assert 0.0 < found["differences"][0]["fields"]["input"] < 1e-14
    words = run("replay", tmp_path / "changed.mcap").stdout
    assert f"plan 3 at {recording['plan'].time[3]:.3f} s: input by" in words and "2 differ" in words


def test_another_door_or_a_schedule_that_forgot_would_give_other_plans(recording, planner, tmp_path):
    heavier = of_plans(lambda _, plan: {"hinge": [plan["hinge"][0], plan["hinge"][1] - 0.5, *plan["hinge"][2:]]})
    found = replay_plans(Recording.load(changed(recording, tmp_path / "heavier.mcap", heavier)), planner)
    assert len(found.differences) > 20
    colder = changed(recording, tmp_path / "colder.mcap", of_plans(lambda k, _: {"cold": k in (0, 10)}))
    found = replay_plans(Recording.load(colder), planner)
    assert (found.cold, found.differences[0].plan) == (2, 10)


def test_a_recording_that_does_not_say_enough_is_refused(recording, planner, tmp_path):
    def change(topic: str, k: int, message: dict[str, Any]) -> dict[str, Any]:
        return {name: value for name, value in message.items() if name != "cold"}

    with pytest.raises(RecordingError, match="no cold"):
        replay_plans(Recording.load(changed(recording, tmp_path / "changed.mcap", change)), planner)


def test_a_recording_that_was_cut_off_is_replayed_as_far_as_it_goes(flight, tmp_path):
    data = (flight / "recording.mcap").read_bytes()
    (tmp_path / "recording.mcap").write_bytes(data[: int(0.9 * len(data))])
    shutil.copy(flight / "recording.mcap", tmp_path / "whole.mcap")
    result = run("replay", tmp_path)
    assert result.exit_code == 0, result.output
    assert "every bit" in result.stdout
    assert "cut off" in run("export", tmp_path).stdout
