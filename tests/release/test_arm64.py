"""Linux on ARM64: the index has a wheel of every dependency, for every Python that doorman runs on; no machine is needed.

`pip install --dry-run` resolves as it would there. Extras whose package has no wheel for ARM64 are named here and on the set-up
page; a test fails as soon as one appears. Needs the index, and minutes: pip downloads what it resolves.
"""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
FROM_SOURCE = {"mocap": "motioncapture", "ros2": "cyclonedds"}
"""Package without a wheel for ARM64, by extra."""
PLATFORMS = ("manylinux_2_28_aarch64", "manylinux_2_27_aarch64", "manylinux_2_17_aarch64", "manylinux2014_aarch64")
PYTHONS = ("3.11", "3.12", "3.13")


def resolved(requirements: list[str], python: str, tmp_path: Path) -> subprocess.CompletedProcess[str]:
    (tmp_path / "requirements.txt").write_text("\n".join(requirements))
    platforms = [word for platform in PLATFORMS for word in ("--platform", platform)]
    return subprocess.run(
        [sys.executable, "-m", "pip", "install", "--dry-run", "--quiet", "--ignore-installed", "--target", str(tmp_path / "none"),
         "--only-binary=:all:", "--implementation", "cp", "--python-version", python, *platforms,
         "--requirement", str(tmp_path / "requirements.txt")],
        capture_output=True, text=True, check=False, timeout=900,
    )  # fmt: skip


def requirements() -> list[str]:
    texts = [*PROJECT["dependencies"], *(text for texts in PROJECT["optional-dependencies"].values() for text in texts)]
    return [text for text in dict.fromkeys(texts) if not text.startswith(tuple(FROM_SOURCE.values()))]


@pytest.mark.slow
@pytest.mark.parametrize("python", PYTHONS)
def test_every_dependency_resolves(python, tmp_path):
    done = resolved(requirements(), python, tmp_path)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("package", FROM_SOURCE.values())
def test_an_exception_is_one(package, tmp_path):
    extras = PROJECT["optional-dependencies"].values()
    (text,) = {text for texts in extras for text in texts if text.startswith(package)}
    done = resolved([text], PYTHONS[-1], tmp_path)
    assert done.returncode != 0 and "No matching distribution" in done.stderr, "it has a wheel now"
