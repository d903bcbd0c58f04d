"""Writes the table of topics in docs/how-to/ros2.md from `doorman.ros2.topics`.

Usage: python docs/make_topics.py
"""

from __future__ import annotations

import re
from pathlib import Path

from doorman.ros2.topics import TOPICS

PAGE = Path(__file__).parent / "how-to" / "ros2.md"
HEAD = "| topic | type | frame | rate | kept for late subscribers | what |\n| --- | --- | --- | --- | --- | --- |\n"
TABLE = re.compile(r"^\| topic \| type \| frame .*\n(?:^\|.*\n)+", re.MULTILINE)


def table() -> str:
    """The table."""
    rows = (
        (
            f"`{topic.under('doorman')}`",
            f"`{topic.type_name}`",
            topic.frame,
            topic.rate,
            "yes" if topic.latched else "no",
            topic.what,
        )
        for topic in TOPICS
    )
    return HEAD + "".join(f"| {' | '.join(cells)} |\n".replace("|  |", "| |") for cells in rows)


def page(text: str) -> str:
    """The page with its table made anew.

    Args:
        text: The page as it is.
    """
    return TABLE.sub(lambda _: table(), text)


def main() -> None:
    """Write the page."""
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
