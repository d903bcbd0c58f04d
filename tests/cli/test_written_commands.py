"""Every `doorman …` command that README, docs and help show is one that works when it is pasted.

All are parsed by the real application: options exist, values are of their type, scenarios and keys of `--set` too. A command
alone on a line of a shell block, or in the help, is whole; one within a sentence may leave out what is required. Those that
need seconds are run, on a short flight made once: `check`, `view`, `plot`, `export`, `replay`, `merge`, `layout`,
`parameters`, `system`, `vehicle new`, `vehicle origin`, and `--help`, `--version`.
Parsed only are `doctor`, whose answer is this machine's, and `open`, `campaign`, `warmup`, `rig` and `fly`: they take minutes,
or hardware; tests of their own run them.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer.main
from command_line import ROOT, run
from made_logs import tumbling, write_dataflash, write_run, write_ulog

from doorman.cli import app
from doorman.cli.task import load_task
from doorman.hardware.vehicle_file import VehicleFile
from doorman.model import Model
from doorman.resources import urdf_directory

PAGES = [ROOT / "README.md", ROOT / "urdf" / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
COMMANDS: Any = typer.main.get_command(app)
RUN = {"check", "view", "plot", "export", "replay", "merge", "layout"}
PLACES = {"layout": "foxglove", "parameters": "px4", "system": "udev"}
"""What commands take that do not take any word."""
SHELL = re.compile(r"^```(?:sh|bash|console|shell|text)\n(.*?)^```", re.MULTILINE | re.DOTALL)
REDIRECTED = re.compile(r" > [\w./-]+")
"""To a file, which the shell writes."""
INLINE = re.compile(r"`+(doorman(?: [^`]+)?)`+")


def in_shell_blocks(text: str) -> Iterator[str]:
    for block in SHELL.findall(text):
        for line in re.sub(r"\\\n\s*", " ", block).splitlines():
            if line.removeprefix("$ ").startswith("doorman "):
                yield REDIRECTED.sub("", line.removeprefix("$ "))


def in_sentences(text: str) -> Iterator[str]:
    yield from (" ".join(found.split()) for found in INLINE.findall(SHELL.sub("", text)))


def helps() -> dict[str, str]:
    return {"doorman": COMMANDS.help} | dict(_helps("doorman", COMMANDS))


def _helps(prefix: str, group: Any) -> Iterator[tuple[str, str]]:
    for name, command in group.commands.items():
        yield f"{prefix} {name}", command.help
        if hasattr(command, "commands"):
            yield from _helps(f"{prefix} {name}", command)


def words(command: str) -> list[str]:
    return shlex.split(command, comments=True)[1:]


WHOLE = sorted(
    {line for page in PAGES for line in in_shell_blocks(page.read_text(encoding="utf-8"))}
    | {line for text in helps().values() for line in INLINE.findall(text) if line.count(" ") > 1}
)
PARTS = sorted({line for page in PAGES for line in in_sentences(page.read_text(encoding="utf-8"))} - set(WHOLE))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the commands are pasted: with the files that the pages speak of, and two runs."""
    folder = tmp_path_factory.mktemp("pasted")
    for name in ("my_task", "doors"):
        (folder / f"{name}.toml").write_text(
            "[contact]\nheight = 0.7\n[campaign.vary]\ncontact.height = { min = 0.6, max = 0.9 }\n"
        )
    shutil.copy(urdf_directory() / "hexarotor_arm.urdf", folder / "my_vehicle.urdf")
    made = run("vehicle", "new", str(folder / "my.toml"), "--urdf", str(folder / "my_vehicle.urdf"))
    assert made.exit_code == 0, made.output
    at_the_door = ("--set", "mission.start=contact", "--duration", "1.2")
    flown = run("open", "paper", *at_the_door, "--out", str(folder / "runs" / "paper"))
    assert flown.exit_code == 1, flown.output  # not opened in so short a time
    shutil.copytree(folder / "runs" / "paper", folder / "push-3")
    write_run(folder / "runs" / "fly-paper" / "flight.mcap", tumbling(1), 5.0)
    write_ulog(folder / "log.ulg", tumbling(1), 0.0, 8.0, -1.0)
    write_dataflash(folder / "log.bin", tumbling(1), 0.0, 8.0, -1.0)
    os.utime(folder / "runs" / "fly-paper" / "flight.mcap", (0, 0))  # the newest run is the other one
    return folder


@pytest.fixture
def here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(folder)
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)  # `view` says where its page is
    return folder


def parsed(arguments: list[str], whole: bool) -> dict[str, Any]:
    """What a command gets; a required option may be missing unless it is whole."""
    if arguments[0].startswith("-"):
        known = {name for parameter in COMMANDS.params for name in parameter.opts} | {"--help"}
        assert set(arguments) <= known, arguments
        return {}
    command = COMMANDS
    while hasattr(command, "commands"):
        if arguments[0] == "--help":
            return {}
        assert arguments[0] in command.commands, arguments
        command, (name, *arguments) = command.commands[arguments[0]], arguments
        if not arguments and hasattr(command, "commands"):
            assert not whole
            return {}
    arguments = [name, *arguments]
    with COMMANDS.make_context("doorman", [], resilient_parsing=True) as parent:
        if "--help" in arguments:
            return {}
        if not whole:
            required = [one for one in command.params if one.required and one.opts[0] not in arguments]
            needed = [one.opts[0] for one in required if one.param_type_name == "option"]
            if arguments[0] == "fly" and "--vehicle" not in arguments:
                needed += [name for name in ("--pixhawk", "--servos") if name not in arguments]
            given = any(not word.startswith("-") for word in arguments[1:])
            missing = [] if given else [one for one in required if one.param_type_name == "argument"]
            places = [PLACES.get(arguments[0], "1")] * len(missing)
            options = [option for option in command.params if not getattr(option, "is_flag", False)]
            valued = {name for option in options for name in option.opts}
            last = ["1"] if arguments[-1] in valued else []
            filled = [*places, *(word for name in needed for word in (name, "1"))]
            arguments = [arguments[0], *filled, *arguments[1:], *last]
        return dict(command.make_context(arguments[0], arguments[1:], parent=parent).params)


def check_values(values: dict[str, Any]) -> None:
    sources = values.get("scenario") or values.get("scenarios") or []
    for source in [sources] if isinstance(sources, str) else sources:
        task = load_task(source, values.get("settings") or [], values.get("vehicle"))
        if values.get("settings"):  # shipped ones as they are have tests of their own
            Model(task)
    if values.get("vehicle"):
        VehicleFile.load(values["vehicle"])


def test_the_pages_show_commands():
    assert len(WHOLE) > 15 and len(PARTS) > 25
    assert {words(line)[0] for line in WHOLE} >= set(COMMANDS.commands) - {"export", "replay"}
    assert "doorman view" in {line.partition("#")[0].strip() for line in WHOLE}


@pytest.mark.parametrize("line", WHOLE)
def test_a_command_on_a_line_of_its_own_is_whole(line, here):
    assert not re.search(r"[…<>]|\b[A-Z]{3,}\b", line.partition("#")[0]), "a placeholder cannot be pasted"
    check_values(parsed(words(line), whole=True))


@pytest.mark.parametrize("line", PARTS)
def test_a_command_within_a_sentence_exists(line, here):
    assert not re.search(r"[…<>]|\b[A-Z]{3,}\b", line), "a placeholder cannot be pasted"
    if words(line):
        check_values(parsed(words(line), whole=False))


def quick() -> list[str]:
    """One line for each command and set of options, the longest."""
    lines: dict[tuple[str, ...], str] = {}
    for line in sorted({shlex.join(words(line)) for line in [*WHOLE, *PARTS]}, key=lambda line: (len(line), line)):
        name, *rest = line.split() or [""]
        if name in RUN and (name, len(rest)) != ("check", 1):  # of a shipped scenario, `check paper` is enough
            lines[name, *(word for word in rest if word.startswith("-"))] = line
    return [line for line in lines.values() if "my_task" not in line] + ["check paper"]


@pytest.mark.parametrize("line", quick())
def test_a_quick_command_runs(line, here):
    ran = run(*shlex.split(line))
    assert ran.exit_code == 0, ran.output


def test_the_way_from_a_urdf_to_a_flight_runs_as_far_as_it_needs_no_hardware(folder, tmp_path, monkeypatch):
    """In the order of the page; the emulated vehicle is flown by `tests/rig`."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(folder / "my_vehicle.urdf", tmp_path)
    page = (ROOT / "docs" / "how-to" / "your_vehicle.md").read_text(encoding="utf-8")
    lines = [words(line) for line in in_shell_blocks(page)]
    ground = ("check", "parameters", "vehicle new", "vehicle origin")
    quick = [line for line in lines if line[0] in ground or " ".join(line[:2]) in ground]
    assert len(quick) == 4 and lines[0][:2] == ["vehicle", "new"]
    for line in quick:
        ran = run(*line)
        assert ran.exit_code == 0, ran.output
    assert VehicleFile.load("my.toml").values["mocap.origin_attitude"] == (0.0, 0.0, -0.02)


@pytest.mark.parametrize("line", ["--help", "--version", *(f"{name} --help" for name in sorted(COMMANDS.commands))])
def test_help_and_version_run(line):
    assert run(*line.split()).exit_code == 0
