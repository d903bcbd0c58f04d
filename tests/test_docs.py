"""What README and docs promise: their Python runs, their links lead somewhere, their tables agree with the code."""

from __future__ import annotations

import ast
import importlib
import json
import pkgutil
import re
import runpy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import doorman
from doorman.cli import app
from doorman.cli.simulated.open_door import RUN_FILES
from doorman.hardware.vehicle_file import VehicleFile
from doorman.resources import urdf_directory
from doorman.scenario import Scenario

ROOT = Path(__file__).parent.parent
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "urdf/README.md")),
    *sorted(path for path in (ROOT / "docs").rglob("*.md") if "api" not in path.parts),
]
README = PAGES[0].read_text(encoding="utf-8")
COMMAND_LINE = (ROOT / "docs" / "command_line.md").read_text(encoding="utf-8")


def code_blocks(text: str, language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def rows(text: str) -> list[list[str]]:
    """Cells of every table row, without headings' underlines."""
    lines = [line for line in text.splitlines() if line.startswith("|") and not line.startswith("| ---")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def section(text: str, heading: str) -> str:
    """Text below a heading, up to the next one of the same level."""
    level = heading.partition(" ")[0]
    return text.split(f"\n{heading}\n", 1)[1].split(f"\n{level} ", 1)[0]


# ---------------------------------------------------------------- README and command line


@pytest.fixture(scope="module")
def flown_summary() -> dict[str, Any]:
    summary = doorman.simulate(doorman.Scenario.load("paper"), duration=0.2).summary
    assert summary is not None
    return summary


def test_the_python_of_the_readme_runs(capsys):
    blocks = code_blocks(README, "python")
    assert len(blocks) == 1
    names: dict[str, Any] = {}
    exec(compile(blocks[0], "README.md", "exec"), names)
    assert names["plan"].states.shape == (51, 9)
    assert names["flight"].summary["outcome"] == "completed"
    assert "(51, 9) (50, 8)" in capsys.readouterr().out


def test_the_docs_list_the_keys_of_the_summary(flown_summary):
    table = {name for row in rows(section(COMMAND_LINE, "## The summary")) for name in re.findall(r"`(\w+)`", row[0])}
    assert set(flown_summary) <= table
    assert table - set(flown_summary) == set()


def test_the_docs_list_the_files_of_a_run():
    names = {
        name
        for row in rows(section(COMMAND_LINE, "## What a run leaves"))
        for name in re.findall(r"`(\w+\.\w+)`", row[0])
    }
    assert names == set(RUN_FILES)


COMMANDS = [line for page in (README, COMMAND_LINE) for block in code_blocks(page, "sh") for line in block.splitlines()]


@pytest.mark.parametrize("line", [line for line in COMMANDS if line])
def test_commands_of_the_readme_exist(line, monkeypatch):
    words = line.partition("#")[0].split()
    if words[0] == "make":
        assert re.search(rf"^{words[1]}:", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    elif words[0] == "pip":
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
            "optional-dependencies"
        ]
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


# ---------------------------------------------------------------- how-to pages


WITHOUT_PYTHON = ("first_day",)
RUN = [
    *(page for page in sorted((ROOT / "docs" / "how-to").glob("*.md")) if page.stem not in WITHOUT_PYTHON),
    *(ROOT / "docs" / f"{name}.md" for name in ("viewing", "scenario", "estimation")),
]


@pytest.mark.docs
@pytest.mark.parametrize("page", RUN, ids=lambda page: page.stem)
def test_the_python_of_the_how_to_pages_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = code_blocks(page.read_text(encoding="utf-8"), "python")
    assert blocks
    names: dict[str, Any] = {"__name__": page.stem}
    for block in blocks:
        exec(compile(block, page.name, "exec"), names)


# ---------------------------------------------------------------- the library's pages


API = sorted((ROOT / "docs" / "api").glob("*.md"))


@pytest.mark.docs
@pytest.mark.parametrize("page", API, ids=lambda page: page.stem)
def test_the_example_of_a_package_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for block in code_blocks(page.read_text(encoding="utf-8"), "python"):
        exec(compile(block, page.name, "exec"), {"__name__": page.stem})


def exported_names() -> dict[str, set[str]]:
    """Public names by package."""
    packages = [module.name for module in pkgutil.walk_packages(doorman.__path__, "doorman.") if module.ispkg]
    inside = ("doorman.cli", "doorman.compilation", "doorman.rig.emulators", "doorman.summary")
    public = ["doorman", *(name for name in packages if not name.startswith(inside))]
    return {name: set(getattr(importlib.import_module(name), "__all__", ())) for name in public}


def test_every_public_name_is_used_in_the_example_of_its_package():
    used: set[tuple[str, str]] = set()
    for page in API:
        for block in code_blocks(page.read_text(encoding="utf-8"), "python"):
            tree = ast.parse(block)
            names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
            for node in ast.walk(tree):
                if isinstance(node, ast.ImportFrom):
                    used |= {
                        (node.module or "", alias.name) for alias in node.names if (alias.asname or alias.name) in names
                    }
                elif isinstance(node, ast.Attribute):
                    used.add((ast.unparse(node.value), node.attr))
    missing = {(package, name) for package, names in exported_names().items() for name in names} - used
    assert missing == set()


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
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if not target.startswith("https://"):
            assert (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_that_pages_name_exist(page):
    for path in re.findall(r"`((?:doorman|docs|examples|tests|urdf)/[\w./]*)`", page.read_text(encoding="utf-8")):
        assert (ROOT / path).exists(), path


def test_rooms_and_modules_of_the_architecture_exist():
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    named = set(re.findall(r"\b([a-z_0-9]+)/", code_blocks(text, "text")[0]))
    folders = [path.parent for path in (ROOT / "doorman").rglob("__init__.py")]
    assert named <= {path.name for path in folders}
    assert {path.name for path in folders if path.parent == ROOT / "doorman"} - named == {"compilation", "numba_types"}
    for path in re.findall(r"`([\w/]+(?:\.py|/))`", text):
        assert (ROOT / path).exists() or (ROOT / "doorman" / path).exists(), path


def test_the_modules_page_is_made_from_the_docstrings():
    made = runpy.run_path(str(ROOT / "docs" / "make_modules.py"))
    assert made["PAGE"].read_text(encoding="utf-8") == made["page"](), "run: python docs/make_modules.py"
    named = set(re.findall(r"\| `([\w/]+\.py)` \|", made["page"]()))
    files = (ROOT / "doorman").rglob("*.py")
    assert named == {str(p.relative_to(ROOT / "doorman")) for p in files if not p.name.startswith("__")}


def test_the_tables_of_settings_are_made_from_the_docstrings():
    made = runpy.run_path(str(ROOT / "docs" / "make_settings.py"))
    text = made["PAGE"].read_text(encoding="utf-8")
    assert text == made["page"](text), "run: python docs/make_settings.py"
    assert text == made["page"](text.replace("| rad/s |", "| rad |")), "whatever the tables say, they are made anew"
    assert made["LINKS"].read_text(encoding="utf-8") == made["links_page"](), "run: python docs/make_settings.py"


def test_the_table_of_topics_is_made_from_the_code():
    made = runpy.run_path(str(ROOT / "docs" / "make_topics.py"))
    text = made["PAGE"].read_text(encoding="utf-8")
    assert text == made["page"](text), "run: python docs/make_topics.py"
    assert text == made["page"](text.replace("every tick", "never")), "whatever the table says, it is made anew"


def test_the_table_of_names_is_made_from_the_vocabulary():
    made = runpy.run_path(str(ROOT / "docs" / "make_names.py"))
    text = made["PAGE"].read_text(encoding="utf-8")
    assert text == made["page"](text), "run: python docs/make_names.py"
    assert text == made["page"](text.replace("| `thrust` |", "| `push` |"))
