"""The command line: overrides, exit status, one-line errors, and what a run leaves behind."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
import urllib.request
from io import StringIO
from pathlib import Path

import pytest
from at_the_door import AT_THE_DOOR
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from typer.testing import CliRunner, Result

import doorman
from doorman.cli import app
from doorman.cli.display import flight_progress, warmup_progress
from doorman.cli.effective import effective_toml
from doorman.cli.open_door import RUN_FILES
from doorman.cli.overrides import parse_overrides
from doorman.compilation import KernelCounts, cache_content
from doorman.exceptions import ScenarioError
from doorman.feasibility import Finding, Report, Severity
from doorman.recording import Recording
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

ROOT = Path(__file__).parent.parent
COMMAND = [sys.executable, "-c", "from doorman.cli import main; main()"]


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments), env={"COLUMNS": "100", "TERM": "dumb"})


def start(*arguments: str, folder: Path) -> subprocess.Popen[str]:
    """The command in a process of its own, with Ctrl-C as in a terminal whatever this process does with it."""
    return subprocess.Popen(
        [*COMMAND, *arguments], cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT)}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip


def assert_bad_input(result: Result, *words: str) -> None:
    """One line on stderr, nothing on stdout, exit status 2, and no exception that escaped."""
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit)
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("doorman: error: ")
    assert "Traceback" not in result.stderr
    for word in words:
        assert word in result.stderr, result.stderr


# ---------------------------------------------------------------- overrides


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("planner.margin=0.01", "planner.margin", 0.01),
        ("contact.kind=push", "contact.kind", "push"),
        ('contact.kind="push"', "contact.kind", "push"),
        ("door.urdf=../doors/heavy.urdf", "door.urdf", "../doors/heavy.urdf"),
        ("door.urdf=my doors/heavy-2.urdf", "door.urdf", "my doors/heavy-2.urdf"),
        ("start.arm=[0, 1.0, -0.6, -0.4]", "start.arm", [0, 1.0, -0.6, -0.4]),
        (" planner.horizon_steps = 20 ", "planner.horizon_steps", 20),
        ("x=true", "x", True),
        ("x={a = 1}", "x", {"a": 1}),
        ('x="a=b"', "x", "a=b"),
    ],
)
def test_the_value_of_an_override_is_toml_or_a_bare_word(text, key, value):
    assert parse_overrides([text]) == {key: value}


def test_the_last_override_of_a_key_wins():
    assert parse_overrides(["a.b=1", "c=2", "a.b=3"]) == {"a.b": 3, "c": 2}


@pytest.mark.parametrize(
    "text",
    ["", "=", "=3", "planner.margin", "planner margin=1", "a..b=1", ".a=1", "a=", "a=[1", 'a="b', "a=1 2", "a=1\nb = 2",
     "a=1.2.3", "a=# comment", "a='", "[a]=1", "a=" + "[" * 3000, "a=" + "9" * 5000],
    ids=lambda text: repr(text[:20]),
)  # fmt: skip
def test_what_is_no_override_is_an_error(text):
    with pytest.raises(ScenarioError) as caught:
        parse_overrides([text])
    assert caught.value.field.startswith("--set")
    assert caught.value.given is not None
    assert caught.value.allowed is not None


# ---------------------------------------------------------------- the effective scenario


@given(
    height=st.floats(0.0, 1.6),
    arm=st.none() | st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4),
    kind=st.sampled_from(["grip", "push"]),
    noise=st.floats(0.0, 1e-300) | st.floats(0.0, 1e300),
    name=st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=8),
)
def test_the_effective_scenario_loads_as_the_same(tmp_path_factory, height, arm, kind, noise, name):
    overrides = {"contact.height": height, "contact.kind": kind, "simulation.noise.position": noise, "door.leaf": name}
    if arm is not None:
        overrides["start.arm"] = arm
    scenario = Scenario.load("paper", overrides)
    path = tmp_path_factory.getbasetemp() / "effective.toml"
    path.write_text(effective_toml(scenario), encoding="utf-8")
    assert Scenario.load(path).model_dump() == scenario.model_dump()


def test_the_effective_scenario_finds_its_urdfs_from_elsewhere(tmp_path):
    (tmp_path / "here").mkdir()
    (tmp_path / "there").mkdir()
    (tmp_path / "here" / "my door.urdf").write_text((urdf_directory() / "hinged_door.urdf").read_text(encoding="utf-8"))
    (tmp_path / "here" / "task.toml").write_text('[door]\nurdf = "my door.urdf"\n')
    (tmp_path / "there" / "task.toml").write_text(effective_toml(Scenario.load(tmp_path / "here" / "task.toml")))
    moved = Scenario.load(tmp_path / "there" / "task.toml")
    assert moved.door_urdf == (tmp_path / "here" / "my door.urdf").resolve()
    assert moved.vehicle.urdf == "hexarotor_arm"


# ---------------------------------------------------------------- help


def test_help_is_a_page_of_documentation():
    text = run("--help").output
    for words in ("open", "check", "warmup", "SCENARIO", "paper", "push", "Exit status", "--version", "doorman open"):
        assert words in text
    for command, options in {
        "open": ("--set", "--out", "--duration", "--seed", "--realtime", "--view"),
        "check": ("--set",),
        "warmup": ("--set",),
    }.items():
        text = run(command, "--help").output
        for option in (*options, "--json"):
            assert option in text


def test_every_command_gives_its_result_as_json():
    for command in ("open", "check", "warmup", "rig", "fly", "campaign", "view", "export", "plot", "replay"):
        assert command in run("--help").output
        assert "--json" in run(command, "--help").output, command


def complete(*words: str, folder: Path) -> list[str]:
    """What bash is offered for the last word."""
    environment = {
        "_DOORMAN_COMPLETE": "complete_bash",
        "COMP_WORDS": " ".join(["doorman", *words]),
        "COMP_CWORD": str(len(words)),
    }
    ran = subprocess.run(
        COMMAND, cwd=folder, env={**os.environ, "PYTHONPATH": str(ROOT), **environment}, capture_output=True, text=True,
        timeout=120, check=False,
    )  # fmt: skip
    assert ran.stderr == ""
    return ran.stdout.split()


def test_the_shell_completes_commands_scenarios_and_keys(tmp_path):
    (tmp_path / "task.toml").write_text("")
    (tmp_path / "doors").mkdir()
    (tmp_path / "doors" / "heavy.toml").write_text("")
    assert complete("cam", folder=tmp_path) == ["campaign"]
    assert complete("open", "pu", folder=tmp_path) == ["push", "push_campaign"]
    assert complete("check", "ta", folder=tmp_path) == ["task.toml"]
    assert complete("open", "doors/", folder=tmp_path) == ["doors/heavy.toml"]
    assert complete("open", "--real", folder=tmp_path) == ["--realtime"]
    keys = complete("open", "--set", "planner.weights.", folder=tmp_path)
    assert keys == ["planner.weights.state=", "planner.weights.terminal=", "planner.weights.input="]


def test_the_completion_script_is_one_that_bash_takes(tmp_path):
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "_DOORMAN_COMPLETE": "source_bash"}
    script = subprocess.run(COMMAND, env=environment, capture_output=True, text=True, timeout=120, check=True).stdout
    (tmp_path / "completion.sh").write_text(script)
    asked = f"source {tmp_path / 'completion.sh'} && complete -p doorman"
    ran = subprocess.run(["bash", "-c", asked], capture_output=True, text=True, timeout=60, check=False)
    assert ran.returncode == 0 and "doorman" in ran.stdout, ran.stderr


def test_the_version():
    result = run("--version")
    assert (result.exit_code, result.stdout) == (0, f"doorman {doorman.__version__}\n")


# ---------------------------------------------------------------- bad input


@pytest.fixture(params=["open", "check", "warmup"])
def command(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    return request.param


BAD_SCENARIOS = {
    "wrong type": ('[contact]\nheight = "high"', ["contact.height", "given 'high'", "allowed: a number"]),
    "unknown key": ("[planner]\nmargins = 0.01", ["planner.margins", "nearest is 'margin'"]),
    "not a number": ("[start]\ndoor_angle = nan", ["start.door_angle", "given nan", "finite"]),
    "infinite": ("[planner]\nrate = inf", ["planner.rate", "given inf", "finite"]),
    "out of range": ("[planner]\nmargin = -0.1", ["planner.margin", "given -0.1", "greater than or equal to 0"]),
    "boolean": ("[planner]\nrate = true", ["planner.rate", "given True", "a number"]),
    "huge integer": (f"[planner]\niterations = {10**40}", ["planner.iterations", "less than or equal to"]),
    "section that is a value": ("planner = 3", ["planner", "given 3", "a table"]),
    "syntax": ("[planner\n", ["not valid TOML"]),
    "not UTF-8": ("\xff".encode("latin-1"), ["not valid TOML", "UTF-8"]),
    "off the leaf": ("[contact]\ndistance_from_hinge = 1.5", ["contact.distance_from_hinge", "given 1.5", "1.2 m"]),
    "wrong number of angles": ("[goal]\narm = [0.0]", ["goal.arm", "given 1", "allowed: 4"]),
    "missing URDF": ('[door]\nurdf = "gone.urdf"', ["door.urdf", "given 'gone.urdf'", "hinged_door"]),
}


@pytest.mark.parametrize(("text", "words"), BAD_SCENARIOS.values(), ids=BAD_SCENARIOS)
def test_a_bad_scenario_is_one_line_and_status_2(command, text, words):
    Path("task.toml").write_bytes(text if isinstance(text, bytes) else text.encode())
    assert_bad_input(run(command, "task.toml"), "task.toml", *words)
    assert not Path("runs").exists()


BAD_URDFS = {
    "malformed": ("</robot>", "", ["not well-formed XML"]),
    "not a URDF": ("robot", "model", ["root element", "given 'model'", "allowed: <robot>"]),
    "no leaf": ('"leaf"', '"slab"', ["door.leaf", "given 'leaf'", "slab"]),
    "no hinge": ('joint name="hinge"', 'joint name="pivot"', ["hinge", "pivot"]),
    "no mass": ('<mass value="11"/>', '<mass value="0"/>', ["leaf", "mass", "given 0.0", "> 0 kg"]),
    "no number": ('<mass value="11"/>', '<mass value="nan"/>', ["mass", "given 'nan'", "finite"]),
}


@pytest.mark.parametrize(("old", "new", "words"), BAD_URDFS.values(), ids=BAD_URDFS)
def test_a_bad_urdf_is_one_line_and_status_2(command, old, new, words):
    text = (urdf_directory() / "hinged_door.urdf").read_text(encoding="utf-8")
    Path("door.urdf").write_text(text.replace(old, new), encoding="utf-8")
    assert_bad_input(run(command, "--set", "door.urdf=door.urdf"), "door.urdf", *words)
    assert not Path("runs").exists()


def test_an_unknown_scenario_is_one_line_and_status_2(command):
    assert_bad_input(run(command, "papr"), "given 'papr'", "did you mean 'paper'?")
    assert_bad_input(run(command, "."), "given '.'", "path of a TOML file")


def test_a_bad_override_is_one_line_and_status_2(command):
    assert_bad_input(run(command, "--set", "planner.margin"), "--set", "KEY=VALUE")
    assert_bad_input(run(command, "--set", "planner.margin=[1"), "--set planner.margin", "given '[1'")
    assert_bad_input(run(command, "--set", "planner.margn=0.1"), "planner.margn", "nearest is 'margin'")
    assert_bad_input(run(command, "--set", "a\nb=1"), "--set")


@pytest.mark.parametrize("duration", ["nan", "inf", "-1", "0", "1e9"])
def test_a_bad_duration_is_one_line_and_status_2(duration):
    assert_bad_input(run("open", "--duration", duration), "--duration", "3600")


@pytest.mark.parametrize(
    "arguments", [["open", "--seed", "-1"], ["open", "--duration", "long"], ["fly"], ["check", "--out", "x"]]
)
def test_bad_usage_has_status_2(arguments):
    result = run(*arguments)
    assert result.exit_code == 2
    assert "Usage" in result.stderr


def test_an_output_folder_that_is_a_file_is_one_line_and_status_2(tmp_path):
    (tmp_path / "taken").write_text("x")
    assert_bad_input(run("open", "--out", str(tmp_path / "taken")), "taken")
    assert_bad_input(run("open", "--out", str(tmp_path / "taken" / "below")), "taken")
    assert (tmp_path / "taken").read_text() == "x"


def test_a_process_leaves_with_status_2_and_no_traceback(tmp_path):
    (tmp_path / "task.toml").write_text("[planner]\nmargin = nan\n")
    process = start("open", "task.toml", folder=tmp_path)
    out, err = process.communicate(timeout=60)
    assert (process.returncode, out) == (2, "")
    assert err.startswith("doorman: error: ") and err.count("\n") == 1 and "planner.margin" in err
    assert [path.name for path in tmp_path.iterdir()] == ["task.toml"]


def test_a_missing_extra_is_named(tmp_path):
    code = "import sys; sys.modules['mujoco'] = None; from doorman.cli import main; main()"
    ran = subprocess.run(
        [sys.executable, "-c", code, "open", "--out", "run"], cwd=tmp_path, capture_output=True, text=True, timeout=120,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False,
    )  # fmt: skip
    assert ran.returncode == 2
    assert "doorman[sim]" in ran.stderr and ran.stderr.count("\n") == 1


# ---------------------------------------------------------------- open


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    """The paper's task, flown once for all tests below."""
    folder = tmp_path_factory.mktemp("flight")
    return run("open", "paper", "--out", str(folder / "run"), "--seed", "5"), folder / "run"


def test_the_door_opens_and_the_status_is_0(flight):
    result, folder = flight
    assert result.exit_code == 0, result.output
    assert "The door was opened" in result.stdout
    assert "door's angle at the end" in result.stdout
    assert str(folder) in result.stdout.replace("\n", "")
    assert result.stderr == ""


def test_a_run_leaves_every_file(flight):
    _, folder = flight
    assert {path.name for path in folder.iterdir()} == set(RUN_FILES)
    for name in ("states", "constraints"):
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
        assert (folder / f"{name}.pdf").read_bytes().startswith(b"%PDF")
    page = (folder / "replay.html").read_text(encoding="utf-8")
    assert "<html" in page and len(page) > 100_000


def test_the_summary_of_a_run_is_that_of_its_recording(flight):
    _, folder = flight
    summary = json.loads((folder / "summary.json").read_text())
    truth = Recording.load(folder / "recording.mcap")["truth"]
    assert summary["opened"] is True
    assert summary["final_door_angle_deg"] == pytest.approx(truth["door_angle"][-1] * 57.29577951308232, abs=1e-9)
    assert summary["collisions"] == 0
    assert summary["min_clearance_m"] > 0.0


def test_the_scenario_of_a_run_is_the_one_that_was_flown(flight):
    _, folder = flight
    tables = tomllib.loads((folder / "scenario.toml").read_text(encoding="utf-8"))
    assert tables["contact"] == {"distance_from_hinge": 0.7, "height": 0.8, "kind": "grip"}
    flown = Scenario.load(folder / "scenario.toml")
    assert flown.model_dump() == Scenario.load("paper").model_dump()


def test_json_is_the_only_thing_on_stdout_and_a_shut_door_is_status_1(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("open", "--duration", "0.3", "--set", "planner.margin=0.03", "--json")
    assert result.exit_code == 1
    summary = json.loads(result.stdout)
    assert summary["opened"] is False
    assert summary["time_to_open_s"] is None
    assert result.stderr.count("\n") == 1 and "not opened" in result.stderr
    (folder,) = (tmp_path / "runs").iterdir()
    assert folder.name.startswith("paper-")
    assert json.loads((folder / "summary.json").read_text()) == summary
    assert Scenario.load(folder / "scenario.toml").planner.margin == 0.03


def test_the_seed_decides(tmp_path, monkeypatch):
    monkeypatch.setattr("doorman.cli.open_door.write_pictures", lambda *_: None)
    at_the_door = [word for key, value in AT_THE_DOOR.items() for word in ("--set", f"{key}={value}")]
    summaries = [
        json.loads(
            run("open", "--duration", "0.2", "--seed", seed, "--json", "--out", str(tmp_path), *at_the_door).stdout
        )
        for seed in ("1", "1", "2")
    ]
    angles = [summary["final_door_angle_deg"] for summary in summaries]
    assert angles[0] == angles[1] != angles[2]


def test_an_older_run_in_the_folder_is_replaced(tmp_path):
    for name in RUN_FILES:
        (tmp_path / name).write_text("old")
    (tmp_path / "notes.txt").write_text("mine")
    run("open", "--duration", "0.2", "--out", str(tmp_path))
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert all((tmp_path / name).read_bytes() != b"old" for name in RUN_FILES)


def test_the_progress_bar_shows_the_door_and_the_time_left(monkeypatch):
    terminal = Console(file=StringIO(), force_terminal=True, width=100)
    monkeypatch.setattr("doorman.cli.display.Console", lambda **_: terminal)
    with flight_progress(4.0, shown=True) as on_progress:
        on_progress(1.0, 1.0)
        on_progress(4.0, 0.35)
    text = terminal.file.getvalue()
    for words in ("Preparing", "Flying", "1.0 s", "door at 57°", "4.0 s", "door at 20°", "left"):
        assert words in text


@pytest.mark.parametrize(("shown", "is_terminal"), [(False, True), (True, False)])
def test_there_is_no_progress_bar_for_programs(monkeypatch, shown, is_terminal):
    terminal = Console(file=StringIO(), force_terminal=is_terminal, width=100)
    monkeypatch.setattr("doorman.cli.display.Console", lambda **_: terminal)
    with flight_progress(4.0, shown) as on_progress:
        on_progress(4.0, 0.35)
    assert terminal.file.getvalue() == ""


def test_ctrl_c_keeps_what_was_flown(tmp_path):
    process = start("open", "--out", "run", "--duration", "600", "--realtime", folder=tmp_path)
    recording = tmp_path / "run" / "recording.mcap"
    deadline = time.monotonic() + 120.0
    while not (recording.is_file() and recording.stat().st_size > 300_000):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 1, err
    assert err == ""
    assert "Interrupted after" in out
    assert {path.name for path in (tmp_path / "run").iterdir()} == set(RUN_FILES)
    loaded = Recording.load(recording)
    assert loaded.complete
    assert loaded["truth"].time[-1] > 0.1
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["opened"] is False


def test_ctrl_c_before_the_flight_is_a_sentence(tmp_path, monkeypatch):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("doorman.cli.open_door.Model", interrupted)
    result = run("open", "--out", str(tmp_path / "run"))
    assert result.exit_code == 1
    assert result.stderr == "doorman: interrupted.\n"
    assert not (tmp_path / "run").exists()


# ---------------------------------------------------------------- check


def test_check_says_that_the_paper_is_possible():
    result = run("check")
    assert result.exit_code == 0, result.output
    assert "possible" in result.stdout


def test_check_says_why_a_task_is_not_possible():
    result = run("check", "--set", "vehicle.radius=0.7", "--json")
    assert result.exit_code == 1, result.output
    report = json.loads(result.stdout)
    assert report["possible"] is False
    failed = [finding for finding in report["findings"] if finding["severity"] == "error"]
    assert failed
    for finding in failed:
        assert finding["message"] and finding["advice"]
        assert finding["value"] is not None and finding["limit"] is not None


def test_check_prints_every_finding_and_what_to_change(monkeypatch):
    findings = (
        Finding("reach", Severity.OK, "the arm reaches [far]", 0.5, 0.1, "m"),
        Finding("tilt", Severity.WARNING, "the plan tilts by 31°", 0.54, 0.5, "rad", "a larger control.max_tilt"),
        Finding("doorway width", Severity.ERROR, "the doorway is too narrow", -0.2, 0.0, "m", "a wider door"),
    )
    monkeypatch.setattr("doorman.cli.check.check", lambda scenario: Report("paper", findings))
    result = run("check")
    assert result.exit_code == 1
    for finding in findings:
        assert finding.name in result.stdout
        assert finding.message in result.stdout
        assert finding.advice in result.stdout
    assert result.stdout.splitlines()[-1] == "The scenario 'paper' is not possible: doorway width."


# ---------------------------------------------------------------- warmup


def test_warmup_says_how_many_kernels_how_long_and_where_the_cache_is():
    before = cache_content()
    result = run("warmup", "paper", "push")
    after = cache_content()  # other tests may compile into it meanwhile
    assert result.exit_code == 0, result.output
    assert result.stderr == ""
    said = re.fullmatch(
        r"(\d+ kernels compiled|Nothing to compile), \d+ loaded, in \d+\.\d s\. "
        r"The cache holds (\d+) kernels, (\d+\.\d) MB: (.+)",
        result.stdout.splitlines()[-1],
    )
    assert said, result.stdout
    assert before.kernels <= int(said[2]) <= after.kernels
    assert before.size / 1e6 - 0.05 <= float(said[3]) <= after.size / 1e6 + 0.05
    assert Path(said[4]) == after.directory


def test_warmup_as_json():
    run("warmup", "paper")
    before = cache_content()
    figures = json.loads(run("warmup", "paper", "--set", "planner.margin=0.02", "--json").stdout)
    after = cache_content()
    assert (figures["compiled"], figures["loaded"]) == (0, 0)  # this process has them all
    assert before.kernels <= figures["cache_kernels"] <= after.kernels
    assert before.size <= figures["cache_bytes"] <= after.size
    assert Path(figures["cache_directory"]) == after.directory
    assert figures["seconds"] > 0.0


def test_warmup_does_without_the_simulator(tmp_path):
    code = "import sys; sys.modules['mujoco'] = None; from doorman.cli import main; main()"
    ran = subprocess.run(
        [sys.executable, "-c", code, "warmup", "paper"], cwd=tmp_path, capture_output=True, text=True, timeout=600,
        env={**os.environ, "PYTHONPATH": str(ROOT)}, check=False,
    )  # fmt: skip
    assert (ran.returncode, ran.stderr) == (0, "")
    assert "The cache holds" in ran.stdout


def test_the_progress_bar_of_a_warmup_shows_the_step_and_the_kernels(monkeypatch):
    terminal = Console(file=StringIO(), force_terminal=True, width=120)
    monkeypatch.setattr("doorman.cli.display.Console", lambda **_: terminal)
    counts = iter(range(7, 1000))
    with warmup_progress(2, lambda: KernelCounts(next(counts), 0), shown=True) as on_step:
        on_step("paper: planner")
        on_step("paper: check")
    text = terminal.file.getvalue()
    for words in ("paper: planner", "paper: check", "kernels compiled: 1", "0:00:00"):
        assert words in text


@pytest.mark.parametrize(("shown", "is_terminal"), [(False, True), (True, False)])
def test_there_is_no_progress_bar_of_a_warmup_for_programs(monkeypatch, shown, is_terminal):
    terminal = Console(file=StringIO(), force_terminal=is_terminal, width=100)
    monkeypatch.setattr("doorman.cli.display.Console", lambda **_: terminal)
    with warmup_progress(1, lambda: KernelCounts(0, 0), shown) as on_step:
        on_step("paper: planner")
    assert terminal.file.getvalue() == ""


def test_the_flight_is_served_while_it_is_flown(tmp_path):
    settings = [word for key, value in AT_THE_DOOR.items() for word in ("--set", f"{key}={value}")]
    process = start("open", "--out", "run", "--duration", "1", "--view", "--json", *settings, folder=tmp_path)
    try:
        address = re.search(r"http://127\.0\.0\.1:\d+/", process.stderr.readline())[0]
        with urllib.request.urlopen(f"{address}frames", timeout=300) as answer:
            sent = answer.read().decode()
        assert sent.count('"poses":') >= 29 and "event: end" in sent
        assert json.loads(process.communicate(timeout=300)[0])["duration_s"] == pytest.approx(1.0, abs=0.02)
    finally:
        process.kill()
        process.communicate()
