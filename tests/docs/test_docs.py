"""What README and docs promise: their Python runs, their links lead somewhere, their tables agree with the code."""

from __future__ import annotations

import json
import re
import runpy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from doorman.cli import app
from doorman.hardware.vehicle_file import VehicleFile
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

ROOT = Path(__file__).parents[2]
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "urdf/README.md")),
    *sorted(path for path in (ROOT / "docs").rglob("*.md") if "api" not in path.parts),
]
README = PAGES[0].read_text(encoding="utf-8")
COMMAND_LINE = (ROOT / "docs" / "command_line.md").read_text(encoding="utf-8")


def code_blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


# ---------------------------------------------------------------- README and command line


def test_the_python_of_the_readme_runs(capsys):
    blocks = code_blocks(README, "python")
    assert len(blocks) == 1
    names: dict[str, Any] = {}
    exec(compile(blocks[0], "README.md", "exec"), names)
    assert names["plan"].states.shape == (51, 9)
    assert names["flight"].summary["outcome"] == "completed"
    assert "(51, 9) (50, 8)" in capsys.readouterr().out


COMMANDS = [line for page in (README, COMMAND_LINE) for block in code_blocks(page, "sh") for line in block.splitlines()]


@pytest.mark.parametrize("line", [line for line in COMMANDS if line])
def test_commands_of_the_readme_exist(line, monkeypatch):
    words = line.partition("#")[0].split()
    if words[0] == "make":
        assert re.search(rf"^{words[1]}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    elif words[0] == "pip":
        project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
        extras = project["optional-dependencies"]
        assert set(re.search(r"\[(.+)\]", words[-1]).group(1).split(",")) == set(extras)
    else:
        assert words[0] == "doorman"
        outcome = CliRunner().invoke(app, [*words[1:], "--help"])
        assert outcome.exit_code == 0, outcome.output


def test_the_toml_of_the_readme_and_the_docs_is_a_scenario(tmp_path):
    for name, door in (("my_vehicle.urdf", "hexarotor_arm"), ("my_door.urdf", "hinged_door")):
        (tmp_path / name).write_text((urdf_directory() / f"{door}.urdf").read_text(encoding="utf-8"))
    blocks = [block for page in PAGES for block in code_blocks(page.read_text(encoding="utf-8"), "toml")]
    assert len(blocks) >= 2
    for block in blocks:
        (tmp_path / "task.toml").write_text(block)
        if "[servos]" in block or "[door_sensor" in block:
            VehicleFile.load(tmp_path / "task.toml")
        else:
            Scenario.load(tmp_path / "task.toml")


# ---------------------------------------------------------------- how-to pages, and those of the library


WITHOUT_PYTHON = ("first_day",)
RUN = [
    *(page for page in sorted((ROOT / "docs" / "how-to").glob("*.md")) if page.stem not in WITHOUT_PYTHON),
    *(ROOT / "docs" / f"{name}.md" for name in ("viewing", "scenario", "estimation")),
    *sorted((ROOT / "docs" / "api").glob("*.md")),
]


@pytest.mark.docs
@pytest.mark.parametrize("page", RUN, ids=lambda page: page.stem)
def test_the_python_of_a_page_runs(page, tmp_path, monkeypatch):
    """The blocks of a how-to page follow each other; those of a page of the library stand alone."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": page.stem}
    blocks = code_blocks(page.read_text(encoding="utf-8"), "python")
    assert blocks or page.parent.name == "api"
    for block in blocks:
        exec(compile(block, page.name, "exec"), dict(names) if page.parent.name == "api" else names)


# ---------------------------------------------------------------- examples


EXAMPLES = {
    "open_the_door": "the door ended at",
    "your_door": "friction 10.0 N m: not possible",
    "your_vehicle": "goal: joints",
    "your_constraint": "1 constraints of mine: the vehicle rises to 1.320 m",
    "your_cost": "1 costs of mine",
    "your_backend": "3 ticks late",
    "knock_twice": "pull opened after ['approach', 'knock', 'touch']",
    "many_flights": "standard deviation",
    "many_problems": "200 of 200 solved",
    "plot_a_recording": "written: door.png and replay.html",
    "plan_from_your_estimate": "replan: median",
}
"""What they print, among other things; `fly_the_door` is flown by `tests/rig`, `ocp_pendulum` run by `tests/ocp/toys`;
`learn_to_open` takes minutes, and an extra of 1 GB."""


@pytest.mark.docs
@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_runs(name, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(ROOT / "examples" / f"{name}.py"), run_name="__main__")
    assert EXAMPLES[name] in capsys.readouterr().out


def test_every_example_is_run():
    names = {path.stem for path in (ROOT / "examples").glob("*.py")}
    assert names == {*EXAMPLES, "fly_the_door", "learn_to_open", "ocp_pendulum"}


def test_notebooks_are_kept_with_their_results():
    """`make docs` executes them anew; who reads one in the repository sees numbers and pictures."""
    for path in (ROOT / "examples").glob("*.ipynb"):
        cells = [cell for cell in json.loads(path.read_text(encoding="utf-8"))["cells"] if cell["cell_type"] == "code"]
        assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1)), path.name
        outputs = [output for cell in cells for output in cell["outputs"]]
        assert any("image/png" in output.get("data", {}) for output in outputs), path.name
        assert not any(output["output_type"] == "error" for output in outputs), path.name


# ---------------------------------------------------------------- docs


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_and_named_files_lead_somewhere(page):
    text = page.read_text(encoding="utf-8")
    links = {page.parent / target for target in re.findall(r"\]\(([^)#]+)[^)]*\)", text) if "https://" not in target}
    named = {ROOT / path for path in re.findall(r"`((?:doorman|docs|examples|tests|urdf)/[\w./]*)`", text)}
    assert {str(path) for path in links | named if not path.exists()} == set()


def test_the_modules_page_is_made_from_the_docstrings():
    made = runpy.run_path(str(ROOT / "docs" / "make_modules.py"))
    assert made["PAGE"].read_text(encoding="utf-8") == made["page"](), "run: python docs/make_modules.py"
    named = set(re.findall(r"\| `([\w/]+\.py)` \|", made["page"]()))
    files = (ROOT / "doorman").rglob("*.py")
    assert named == {str(p.relative_to(ROOT / "doorman")) for p in files if not p.name.startswith("__")}


@pytest.mark.parametrize(
    ("tables", "old", "new"),
    [("settings", "| rad/s |", "| rad |"), ("topics", "every tick", "never"), ("names", "| `thrust` |", "| `push` |")],
)
def test_tables_are_made_from_the_code(tables, old, new):
    made = runpy.run_path(str(ROOT / "docs" / f"make_{tables}.py"))
    text = made["PAGE"].read_text(encoding="utf-8")
    assert text == made["page"](text), f"run: python docs/make_{tables}.py"
    assert text == made["page"](text.replace(old, new)), "whatever the tables say, they are made anew"
    assert tables != "settings" or made["LINKS"].read_text(encoding="utf-8") == made["links_page"]()
