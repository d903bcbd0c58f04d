"""`doorman list`: the scenarios that ship, in the words of their files."""

from __future__ import annotations

from pathlib import Path

from doorman.cli.command import PREPARE, command
from doorman.cli.options import Json


@command(PREPARE, "list")
def list_command(as_json: Json = False) -> int:
    """List the scenarios that ship, in words.

    Each name is a SCENARIO of `doorman check`, `doorman open` and the other commands. The gallery in the documentation shows a
    flight of each.
    """
    from doorman.cli.terminal.display import print_lines, print_result, print_table
    from doorman.resources import scenario_directory, shipped

    words = {name: first_sentence(path) for name, path in shipped(scenario_directory(), ".toml").items()}
    print_result(as_json, words, [])
    if not as_json:
        print_table(("scenario", "task"), words.items())
        print_lines(
            "\nFly one: doorman open pull. See them fly: docs/gallery.md. Your own: a TOML file, docs/scenario.md."
        )
    return 0


def first_sentence(path: Path) -> str:
    """What a scenario's file begins with: a comment whose first sentence says what the task is."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# ").strip())
    sentence, _, _ = " ".join(lines).partition(". ")
    return sentence.rstrip(".") + "."
