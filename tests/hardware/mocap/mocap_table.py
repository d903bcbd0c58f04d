"""Tables of docs/hardware/mocap.md, and faults of its rows that the emulator can switch."""

from __future__ import annotations

import re
from pathlib import Path

from doorman.hardware.mocap import MocapFault

PAGE = (Path(__file__).parents[3] / "docs" / "hardware" / "mocap.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """Rows below a heading, without the table's head."""
    part = PAGE.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in part.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def milliseconds(row: str) -> float:
    """Detection time that the fault table gives for a fault."""
    (found,) = [cells for cells in table("Faults") if cells[0] == row]
    return float(re.fullmatch(r"([\d.]+) ms", found[2])[1])


FAULTS = {
    "packets lost": ({"loss": 0.3}, MocapFault.DROPPED, True, "missing before"),
    "silence: network or Tracker down": ({"silent": True}, MocapFault.SILENT, False, "no packet for"),
    "object occluded, its pose repeats": ({"frozen": True}, MocapFault.OCCLUDED, False, "the pose repeats"),
    "object occluded, its pose is zeros": ({"zeroed": True}, MocapFault.OCCLUDED, False, "the pose repeats"),
    "object not in the stream": ({"absent": True}, MocapFault.MISSING, False, "no object"),
    "another object in the stream": ({"wrong_name": "wand"}, MocapFault.MISSING, False, "the stream holds wand"),
    "single outliers": ({"outliers": 0.2}, MocapFault.OUTLIER, True, "m in"),
    "packets reordered": ({"reorder": 0.3}, MocapFault.REORDERED, True, "after"),
    "packets duplicated": ({"duplicate": 1.0}, MocapFault.DUPLICATED, True, "twice"),
    "damaged packets, noise": ({"truncate": 0.3, "garbage": 0.3}, MocapFault.CORRUPT, True, ""),
    "NaN, infinity, kilometres": ({"not_finite": True}, MocapFault.CORRUPT, False, "impossible pose"),
    "a stray frame number": ({"number_offset": 100_000}, MocapFault.NUMBERING, None, "after"),
    "the frame number stands still": ({"stuck_number": True}, MocapFault.DUPLICATED, False, "twice"),
}
"""What the emulator is told, the fault, whether poses go on meanwhile, and words of the event, by row of the table."""
