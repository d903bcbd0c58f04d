"""Writes the table of names in docs/how-to/add_a_constraint.md from the vocabulary of a door task.

Usage: python docs/make_names.py
"""

from __future__ import annotations

import re
from pathlib import Path

from doorman.kinematics.task import NAMES

PAGE = Path(__file__).parent / "how-to" / "add_a_constraint.md"
MARK = "<!-- docs/make_names.py writes this table -->"
NUMBERS = ("`vehicle.mass`, `door.width`, `contact.height`, …", "numbers of the scenario, as parameters, in SI units")


def page(text: str) -> str:
    """The page with its table made anew."""
    rows = [*((f"`{name}`", what) for name, what in NAMES.items()), NUMBERS]
    table = "\n".join(["| name | what |", "| --- | --- |", *(f"| {name} | {what} |" for name, what in rows)])
    return re.sub(rf"{MARK}\n(\|.*\n)*", f"{MARK}\n{table}\n".replace("\\", r"\\"), text)


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
