"""One verdict: `check`, `open`, `fly` and `simulate` find the same in a task, and none flies what is refused."""

from __future__ import annotations

import importlib
import importlib.util
import json
import math
from pathlib import Path
from typing import Any

import pytest
from command_line import run
from urdf_variants import DOOR, VEHICLE, write_edited

from doorman import simulate
from doorman.exceptions import DoormanError, InfeasibleError
from doorman.feasibility import FeasibilityWarning, Severity, check
from doorman.feasibility.inputs.plant import plant_finding
from doorman.flight import Verdict
from doorman.flight.ground.judgements import judge_scenario
from doorman.model import Model
from doorman.recording import Recording
from doorman.scenario import Scenario

PAPER_ARMS = {"start.arm": [0.0, 1.0, -0.6, -0.4], "goal.arm": [0.0, math.pi / 2, -math.pi / 2, 0.0]}
LEVEL = {"start.attitude": [0.0, 0.0, 0.0]}
HALF_OPEN = {**PAPER_ARMS, "goal.door_angle": math.radians(52.0), "goal.attitude": [0.0, 0.0, math.radians(-38.0)]}
CLOSES = {"start.door_angle": 1.2, "goal.door_angle": 1.4, "goal.attitude": [0.0, 0.0, -0.17]}
"""Towards the frame, and the vehicle: a tip that pushes cannot."""
WEAK = {"vehicle.max_thrust": 38.5}
"""Its rotors cannot carry and steer."""
NEAR_LIMIT = {"goal.door_angle": math.radians(8.0), "goal.attitude": [0.0, 0.0, math.radians(-82.0)]}
"""Possible, with a warning of the tilt."""

BAD: list[tuple[str, str, dict[str, Any]]] = [
    ("direction", "push", CLOSES),
    ("room to let go", "paper", {**PAPER_ARMS, "start.door_angle": math.radians(40.0)}),
    ("room at the touch", "push", {**PAPER_ARMS, **LEVEL, "start.door_angle": math.radians(58.0)}),
    ("room to let go", "paper", HALF_OPEN),
    ("thrust reserve", "paper", {"vehicle.max_thrust": 38.5}),
    ("simulated hinge", "push", {"simulation.door_friction": 9.0}),
    ("height in the doorway", "paper", {**PAPER_ARMS, "contact.height": 1.44, "door.frame_height": 1.9}),
    ("inertias", "paper", {"vehicle.urdf": "thin.urdf"}),
    ("magnitudes", "paper", {"door.urdf": "grams.urdf"}),
]


FEW = {"thrust reserve", "height in the doorway", "inertias"}
"""That the short run looks at."""


def settings(overrides: dict[str, Any]) -> list[str]:
    return [word for key, value in overrides.items() for word in ("--set", f"{key}={json.dumps(value)}")]


@pytest.fixture(scope="module")
def urdfs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A body that is no rigid one, and a leaf of the right mass with an inertia that is no such body's."""
    folder = tmp_path_factory.mktemp("urdfs")
    write_edited(folder / "thin.urdf", VEHICLE, ('ixx="0.045"', 'ixx="0.03"'))
    moments = 'ixx="2.34666667" ixy="0" ixz="0" iyy="3.66666667" iyz="0" izz="1.32"'
    write_edited(folder / "grams.urdf", DOOR, (moments, 'ixx="2.3e4" ixy="0" ixz="0" iyy="3.6e4" iyz="0" izz="1.4e4"'))
    return folder


@pytest.mark.parametrize(
    ("name", "source", "overrides"),
    [pytest.param(*bad, id=bad[0], marks=[] if bad[0] in FEW else pytest.mark.slow) for bad in BAD],
)
def test_what_cannot_work_is_refused_alike(
    urdfs: Path, tmp_path: Path, name: str, source: str, overrides: dict[str, Any]
) -> None:
    given = {key: str(urdfs / value) if key.endswith("urdf") else value for key, value in overrides.items()}
    checked = run("check", source, "--json", *settings(given))
    said = [finding for finding in json.loads(checked.stdout)["findings"] if finding["severity"] == "error"]
    errors = [finding["name"] for finding in said]
    assert checked.exit_code == 1 and name in errors
    assert all(finding["advice"] for finding in said)

    opened = run("open", source, "--json", "--out", str(tmp_path / "run"), *settings(given))
    assert opened.exit_code == 1
    assert [one["name"] for one in json.loads(opened.stdout)["findings"] if one["severity"] == "error"] == errors
    assert name in opened.stderr and "--force" in opened.stderr
    assert not (tmp_path / "run").exists()

    model = Model(Scenario.load(source, given))
    with pytest.raises(InfeasibleError) as refused:
        simulate(model)
    assert list(refused.value.findings) == errors
    assert isinstance(refused.value, DoormanError) and name in str(refused.value)

    row = next(judge_scenario(check(model)))
    assert row.verdict is Verdict.BAD
    assert all(f"{error}: " in row.found for error in errors)


@pytest.fixture
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """They take longer than these flights."""
    monkeypatch.setattr("doorman.visualization.write_pictures", lambda *_: None)


@pytest.mark.usefixtures("no_pictures")
def test_force_flies_all_the_same_and_says_so(tmp_path: Path) -> None:
    result = run("open", "--force", "--json", "--duration", "0.1", "--out", str(tmp_path), *settings(WEAK))
    assert json.loads(result.stdout)["duration_s"] == pytest.approx(0.1, abs=0.01)
    assert "thrust reserve" in result.stderr and "--force" in result.stderr
    header = Recording.load(tmp_path / "recording.mcap").header
    assert header["forced"] is True
    assert "thrust reserve" in [finding["name"] for finding in header["findings"]]


@pytest.mark.usefixtures("no_pictures")
def test_warnings_are_told_and_kept(tmp_path: Path) -> None:
    result = run("open", "--json", "--duration", "0.1", "--out", str(tmp_path), *settings(NEAR_LIMIT))
    assert json.loads(result.stdout)["outcome"] == "cut off"
    assert "warning" in result.stderr and "tilt" in result.stderr
    scenario = Scenario.load("paper", NEAR_LIMIT)
    with pytest.warns(FeasibilityWarning, match="tilt") as warned:
        recording = simulate(scenario, 0.1)
    assert [one.filename for one in warned] == [__file__] * len(warned)
    assert [finding["severity"] for finding in recording.header["findings"]] == ["warning"] * len(warned)
    assert recording.header["forced"] is False


def test_a_forced_flight_without_a_report_checks_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    flown = importlib.import_module("doorman.mission.simulate")
    monkeypatch.setattr(flown, "check", lambda model: pytest.fail("it was checked"))
    recording = simulate(Scenario.load("paper", WEAK), 0.1, force=True)
    assert recording.header["findings"] is None


@pytest.mark.slow
def test_only_a_grip_closes_a_door_towards_the_vehicle() -> None:
    """Flown, from the hover too: such a door ends within 0.5° of its goal."""
    for source, start, possible in (("paper", "contact", True), ("paper", "hover", True), ("push", "contact", False)):
        report = check(Scenario.load(source, {**CLOSES, "mission.start": start}))
        assert report["direction"].ok is possible


def test_what_stands_on_the_way_to_the_leaf_is_refused(tmp_path: Path) -> None:
    bench = '<collision name="bench"><origin xyz="-1.2 0.7 1"/><geometry><box size="0.3 1 2"/></geometry></collision></link>'
    door = write_edited(tmp_path / "bench.urdf", DOOR, ("</link>", bench))
    finding = check(Scenario.load("paper", {"door.urdf": str(door)}))["approach"]
    assert finding.severity is Severity.ERROR and "bench" in finding.message


def test_the_simulators_own_rules_are_those_of_the_check(urdfs: Path) -> None:
    report = check(Scenario.load("paper", {"vehicle.urdf": str(urdfs / "thin.urdf")}))
    for name in ("inertias", "simulator"):
        assert report[name].severity is Severity.ERROR
        assert "thin.urdf" in report[name].message and "base_link" in report[name].message


def test_without_mujoco_the_check_says_what_it_has_not_seen(monkeypatch: pytest.MonkeyPatch, model: Model) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    finding = plant_finding(model)
    assert finding.severity is Severity.WARNING
    assert "not checked" in finding.message and "`sim`" in finding.advice
