"""`doorman list`: the scenarios that ship, in the words of their files."""

from __future__ import annotations

import json
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from doorman.resources import scenario_directory, shipped


def list_scenarios(as_json: bool) -> int:
    words = {name: first_sentence(path) for name, path in shipped(scenario_directory(), ".toml").items()}
    if as_json:
        typer.echo(json.dumps(words, indent=2, ensure_ascii=False))
        return 0
    table = Table("scenario", "task", box=None, pad_edge=False)
    for name, sentence in words.items():
        table.add_row(name, Text(sentence))
    console = Console(highlight=False)
    console.print(table)
    console.print(
        Text("\nFly one: doorman open pull. See them fly: docs/gallery.md. Your own: a TOML file, docs/scenario.md."),
        soft_wrap=True,
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
