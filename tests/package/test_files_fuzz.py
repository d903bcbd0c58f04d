"""A seeded sample of the fuzz in files_fuzz.py, and proof that it would notice."""

from __future__ import annotations

from pathlib import Path

import pytest
from files_fuzz import READERS, fuzz

from doorman.kinematics.urdf import structure as urdf_structure


def test_damaged_files_are_read_or_refused(tmp_path: Path) -> None:
    counts = fuzz(60, 20261123, tmp_path)
    for name, _, _ in READERS:
        assert counts[f"{name} read"] >= 1
        assert counts[f"{name} refused"] >= 20
    for name in ("recording", "ulog", "dataflash"):  # damage costs what it hits
        assert counts[f"{name} read"] >= 40
    assert counts["row refused"] >= 55  # the others have injuries that change nothing
    assert min(counts["mesh read"], counts["mesh refused"]) >= 10


@pytest.mark.slow  # a test of the test above
def test_a_reader_without_its_checks_would_be_noticed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(urdf_structure, "_check_text", lambda *arguments: None)
    with pytest.raises(AssertionError, match=r"door|vehicle"):
        fuzz(400, 1, tmp_path)
