"""Writes the tables of docs/scenario.md from the fields of doorman.scenario and their docstrings.

A docstring is `Meaning [unit].`, and ends with `Default: words.` where the default is no fixed value.

Usage: python docs/make_settings.py
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from doorman.scenario import Scenario
from doorman.scenario.sized_keys import SIZED

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "scenario.md"
HEAD = "| key | default | unit | meaning |\n| --- | --- | --- | --- |\n"
TABLE = re.compile(r"(^## `\[([\w.]+)\]`\n(?:(?!^## |^\| ).*\n)*)(?:^\|.*\n)+", re.MULTILINE)
WORDS = re.compile(r"(?P<meaning>.*?)(?: \[(?P<unit>[^\],]+)\])?\.(?: Default: (?P<default>.*)\.)?", re.DOTALL)
PATH = re.compile(r"\b(docs/[\w/]+\.md|urdf/README\.md)(#[\w-]+)?")


def page(text: str) -> str:
    """The page with its tables made anew.

    Args:
        text: The page as it is.

    Raises:
        SystemExit: if a section of the scenario has no table.
    """
    tables = dict(sections(Scenario))
    if missing := sorted(set(tables) - {name for _, name in TABLE.findall(text)}):
        raise SystemExit(f"{PAGE.name}: no table of {', '.join(missing)}")
    return TABLE.sub(
        lambda found: found[1] + HEAD + "".join(map("{}\n".format, rows(found[2], tables[found[2]]))), text
    )


def sections(table: type[BaseModel], prefix: str = "") -> list[tuple[str, type[BaseModel]]]:
    """Sections with keys of their own, by dotted name."""
    found = []
    for name, field in table.model_fields.items():
        if isinstance(field.default, BaseModel):
            section = type(field.default)
            found += [(prefix + name, section), *sections(section, f"{prefix}{name}.")]
    return found


def rows(table: str, section: type[BaseModel]) -> list[str]:
    """A table's row of every key; † marks a default that grows with vehicle and door.

    Raises:
        SystemExit: if a key's docstring is missing, or not of the form.
    """
    said, made = docstrings(section), []
    for name, field in section.model_fields.items():
        if isinstance(field.default, BaseModel):
            continue
        words = WORDS.fullmatch(said.get(name, ""))
        if words is None or (field.default is None) != (words["default"] is not None):
            raise SystemExit(
                f"{section.__name__}.{name}: want `Meaning [unit].`, and `Default: words.` where it is None"
            )
        default = words["default"] if field.default is None else f"`{written(field.default)}`"
        default += " †" if f"{table}.{name}" in SIZED else ""
        cells = f"`{name}`", linked(default), words["unit"] or "–", linked(small(words["meaning"]))
        made.append(f"| {' | '.join(cells)} |")
    return made


def docstrings(section: type[BaseModel]) -> dict[str, str]:
    """Docstring by field, on one line."""
    body = ast.parse(textwrap.dedent(inspect.getsource(section))).body[0].body  # type: ignore[attr-defined]
    return {
        field.target.id: " ".join(text.value.value.split())
        for field, text in zip(body, body[1:], strict=False)
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name)
        if isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant)
    }


def written(value: Any) -> str:
    """A value as TOML has it."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, tuple):
        return f"[{', '.join(map(written, value))}]"
    return f"{value:.7g}" if isinstance(value, float) and round(value, 4) != value else str(value)


def small(words: str) -> str:
    """Words that begin with a small letter, unless they begin with a symbol."""
    first = words.split(maxsplit=1)[0].rstrip(",;:").replace("-", "")
    plain = first.isascii() and first.isalpha() and (len(first) > 1 or first == "A") and first[1:] == first[1:].lower()
    return words[0].lower() + words[1:] if plain else words


def linked(words: str) -> str:
    """Words with their paths as links, and with table bars escaped."""
    return PATH.sub(
        lambda path: (
            f"[{Path(path[1]).stem}]({path[1].removeprefix('docs/')}{path[2] or ''})"
            if path[1].startswith("docs/")
            else f"[{path[1]}](../{path[0]})"
        ),
        words,
    ).replace("|", "\\|")


if __name__ == "__main__":
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    print(f"written: {PAGE.relative_to(ROOT)}")
