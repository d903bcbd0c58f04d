"""Tables of docs/hardware/mocap.md."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = (Path(__file__).parents[3] / "docs" / "hardware" / "mocap.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """Rows below a heading, without the table's head."""
    part = PAGE.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in part.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def milliseconds(row: str) -> float:
    """Detection time that the fault table gives for a test."""
    (found,) = [cells for cells in table("Faults") if cells[-1] == f"`{row}`"]
    return float(re.fullmatch(r"([\d.]+) ms", found[2])[1])
