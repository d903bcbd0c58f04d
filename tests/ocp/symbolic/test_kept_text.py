"""Printed text on disk: made once, made again where it is damaged, and made every time where nothing can be written."""

from __future__ import annotations

from pathlib import Path

import pytest

from doorman.ocp.kernels.printed import printed_problem
from doorman.ocp.kernels.printed.printed_problem import kept_text


@pytest.fixture
def made() -> list[str]:
    return []


def _text(made: list[str]) -> str:
    return kept_text("key", lambda: (made.append("once more"), "text\nof two lines")[1])


def test_text_is_made_once_and_again_where_it_is_damaged(
    made: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(printed_problem, "cache_directory", lambda: tmp_path)
    assert [_text(made) for _ in range(2)] == ["text\nof two lines"] * 2
    assert len(made) == 1
    (file,) = (tmp_path / "problems").iterdir()
    file.write_text(file.read_text(encoding="utf-8") + "!", encoding="utf-8")
    assert (_text(made), len(made)) == ("text\nof two lines", 2)


def test_text_is_made_where_there_is_no_place_for_it(made: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere() -> Path:
        raise OSError("read-only")

    monkeypatch.setattr(printed_problem, "cache_directory", nowhere)
    assert [_text(made) for _ in range(2)] == ["text\nof two lines"] * 2
    assert len(made) == 2
