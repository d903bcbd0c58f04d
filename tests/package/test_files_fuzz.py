"""A seeded sample of the fuzz in files_fuzz.py."""

from __future__ import annotations

from pathlib import Path

from files_fuzz import READERS, fuzz


def test_damaged_files_are_read_or_refused(tmp_path: Path) -> None:
    counts = fuzz(60, 20261123, tmp_path)
    for name, _, _ in READERS:
        assert counts[f"{name} read"] >= 1
        assert counts[f"{name} refused"] >= 20
    for name in ("recording", "ulog", "dataflash"):  # damage costs what it hits
        assert counts[f"{name} read"] >= 40
    assert counts["row refused"] >= 55  # the others have injuries that change nothing
    assert min(counts["mesh read"], counts["mesh refused"]) >= 10
