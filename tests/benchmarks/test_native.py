"""Solvers built from their sources."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest


@pytest.fixture
def native(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Any:
    monkeypatch.setattr(sys, "path", [str(Path(__file__).parents[2] / "benchmarks"), *sys.path])
    import build_native

    monkeypatch.setattr(build_native, "FOLDER", tmp_path / "built")
    return build_native


def test_a_missing_source_is_named_with_the_step_that_needs_it(
    native: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("NATIVE_SOURCES", str(tmp_path / "nowhere"))
    with pytest.raises(native.BuildError, match=r"acados: cannot clone .*nowhere/acados"):
        native.ACADOS.build()


def test_what_is_built_is_left_alone_until_its_recipe_changes(
    native: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("NATIVE_SOURCES", str(tmp_path / "nowhere"))
    native.ACADOS.folder.mkdir(parents=True)
    (native.ACADOS.folder / "built").write_text(repr(native.ACADOS), encoding="utf-8")
    native.ACADOS.build()
    with pytest.raises(native.BuildError):
        replace(native.ACADOS, options=("-DOTHER=ON",)).build()
