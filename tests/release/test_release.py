"""How a release is made: what checks it, the lowest versions of its dependencies, and the workflows that run both."""

from __future__ import annotations

import re
import runpy
import shutil
from pathlib import Path

import pytest
import yaml
from hatchling.builders.sdist import SdistBuilder
from hatchling.builders.wheel import WheelBuilder

import doorman

ROOT = Path(__file__).parents[2]
RELEASE = runpy.run_path(str(ROOT / ".ci" / "release.py"))
LOWEST = runpy.run_path(str(ROOT / ".ci" / "lowest.py"))
WORKFLOWS = {
    path.name: yaml.safe_load(path.read_text(encoding="utf-8"))
    for path in sorted((ROOT / ".github" / "workflows").glob("*.yml"))
}


# ---------------------------------------------------------------- versions and changelog


def test_nothing_in_this_checkout_keeps_it_from_being_released():
    assert RELEASE["wrong_in_source"](ROOT) == []


FILES = {
    "pyproject.toml": '[project]\nversion = "1.2.0"\n',
    "doorman/__init__.py": '"""A package."""\n\n__version__ = "1.2.0"\n',
    "CITATION.cff": "cff-version: 1.2.0\nversion: 1.2.0\n",
    "CHANGELOG.md": "# Changelog\n\n## [1.2.0] - 2026-12-01\n\n- New.\n\n## [1.1.0] - 2026-11-01\n\n- First.\n",
}


def wrong(folder: Path, tag: str = "", **changed: str) -> list[str]:
    """What is wrong with a small project, some of whose files are others."""
    (folder / "doorman").mkdir()
    for name, text in {**FILES, **changed}.items():
        (folder / name).write_text(text, encoding="utf-8")
    found: list[str] = RELEASE["wrong_in_source"](folder, tag)
    return found


@pytest.mark.parametrize("tag", ["", "v1.2.0"])
def test_a_whole_project_can_be_released(tmp_path, tag):
    assert wrong(tmp_path, tag) == []


def test_between_releases_only_a_tag_is_wrong(tmp_path):
    between = FILES["CHANGELOG.md"].replace("## [1.2.0]", "## [Unreleased]\n\n- More.\n\n## [1.2.0]")
    assert wrong(tmp_path, **{"CHANGELOG.md": between}) == []
    (fault,) = RELEASE["wrong_in_source"](tmp_path, "v1.2.0")
    assert "[Unreleased]" in fault


@pytest.mark.parametrize(
    ("tag", "file", "text", "named"),
    [
        ("v1.3.0", "", "", "v1.2.0"),
        ("1.2.0", "", "", "v1.2.0"),
        ("", "doorman/__init__.py", '__version__ = "1.1.0"\n', "1.1.0"),
        ("", "doorman/__init__.py", '"""A package without a version."""\n', "none"),
        ("", "CITATION.cff", "cff-version: 1.2.0\nversion: 1.1.9\n", "1.1.9"),
        ("", "CHANGELOG.md", "# Changelog\n\n## [1.1.0] - 2026-11-01\n\n- First.\n", "[1.2.0]"),
        ("", "CHANGELOG.md", FILES["CHANGELOG.md"].replace("- New.\n", ""), "[1.2.0]"),
        ("", "CHANGELOG.md", FILES["CHANGELOG.md"].replace(" - 2026-12-01", ""), "date"),
        ("", "CHANGELOG.md", FILES["CHANGELOG.md"].replace("- First.", "- First.\n" * 50 + "- Last."), "51 lines"),
    ],
)
def test_a_fault_is_named(tmp_path, tag, file, text, named):
    (fault,) = wrong(tmp_path, tag, **({file: text} if file else {}))
    assert named in fault


# ---------------------------------------------------------------- wheel and sdist


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dist")
    for builder in (SdistBuilder, WheelBuilder):
        list(builder(str(ROOT)).build(directory=str(folder), versions=["standard"]))
    return folder


def test_wheel_and_sdist_are_as_the_index_wants_them(distributions):
    assert RELEASE["wrong_in_distributions"](distributions, doorman.__version__) == []


def test_other_distributions_are_refused(distributions, tmp_path):
    (fault,) = RELEASE["wrong_in_distributions"](distributions, "9.9.9")
    assert "9.9.9" in fault
    shutil.copy(next(distributions.glob("*.whl")), tmp_path)
    (fault,) = RELEASE["wrong_in_distributions"](tmp_path, doorman.__version__)
    assert "tar.gz" in fault


# ---------------------------------------------------------------- lowest versions


def test_the_lowest_versions_are_the_declared_ones():
    project = {
        "dependencies": ["numpy>=2.0", "Ruamel_Yaml>=0.17.9"],
        "optional-dependencies": {
            "a": ["dask[distributed]>=2026.8", "numpy>=2.1"],
            "b": ["ruamel.yaml>=0.17.10"],
            "test": ["pytest>=8.3", "numpy>=1.0"],
            "docs": ["Sphinx>=8.1"],
        },
    }
    assert LOWEST["lowest"](project) == {"numpy": "2.1", "ruamel-yaml": "0.17.10", "dask": "2026.8"}
    assert LOWEST["tools"](project, "numpy==2.4\npytest==9.2.0\nsphinx==9.0.4\n") == {
        "pytest": "9.2.0", "sphinx": "9.0.4",
    }  # fmt: skip


@pytest.mark.parametrize("requirement", ["numpy", "numpy>2.0", "numpy>=2.0,<3", "numpy>=2.0; sys_platform == 'linux'"])
def test_a_requirement_of_another_form_is_noticed(requirement):
    with pytest.raises(ValueError, match=re.escape(requirement)):
        LOWEST["lowest"]({"dependencies": [requirement], "optional-dependencies": {}})


# ---------------------------------------------------------------- workflows


def test_only_a_checked_tag_is_published():
    jobs = WORKFLOWS["release.yml"]["jobs"]
    publish = jobs["publish"]
    assert publish["if"] == "github.ref_type == 'tag'" and publish["needs"] == "check"
    assert publish["permissions"] == {"id-token": "write"}
    assert [name for name, job in jobs.items() if "permissions" in job] == ["publish"]
    (check,) = [step for step in jobs["check"]["steps"] if "release-check" in step.get("run", "")]
    assert "github.ref_name" in check["env"]["TAG"]
    uploads, downloads = ([step for step in jobs[job]["steps"] if f"actions/{word}-artifact@" in step.get("uses", "")]
                          for job, word in (("check", "upload"), ("publish", "download")))  # fmt: skip
    assert [step["with"]["path"] for step in uploads] == [step["with"]["path"] for step in downloads] == ["dist/"]
