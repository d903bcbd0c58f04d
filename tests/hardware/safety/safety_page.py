"""The page on safety, and its tables."""

from __future__ import annotations

from pathlib import Path

PAGE = (Path(__file__).parents[3] / "docs" / "hardware" / "safety.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """Rows of the table below a heading."""
    part = PAGE.split(f"# {heading}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in part.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]
