"""Writes the tables of docs/scenario.md, and docs/hardware/settings.md, from settings' fields and their docstrings.

A docstring of a scenario's key is `Meaning [unit].`, and ends with `Default: words.` where the default is no fixed value.

Usage: python docs/make_settings.py
"""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from doorman.docstrings import field_docs
from doorman.hardware.door import CameraConfig, DoorSensorConfig, Mark
from doorman.hardware.dynamixel import ServoConfig
from doorman.hardware.mocap import MocapConfig
from doorman.hardware.pixhawk import PixhawkConfig, Rates, Timeouts
from doorman.hardware.vehicle.config import GIVEN
from doorman.scenario import Scenario
from doorman.scenario.sized_keys import SIZED

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "scenario.md"
LINKS = ROOT / "docs" / "hardware" / "settings.md"
LINKS_TOP = """# Settings of the links

`docs/make_settings.py` writes this page from the docstrings of the adapters' settings.
`doorman fly --link pixhawk.min_voltage=14.0` sets a key for one flight.
A [vehicle file](../how-to/your_vehicle.md) keeps keys in its tables `[pixhawk]`, `[servos]`, `[mocap]` and `[door_sensor]`.
In Python they are the fields of the class that each table names. A key with ‡ can be given in Python only: for a flight, doorman
derives it from the scenario and from the other links.
"""
LINK_TABLES = (
    ("pixhawk", PixhawkConfig), ("pixhawk.timeouts", Timeouts), ("pixhawk.rates", Rates), ("servos", ServoConfig),
    ("mocap", MocapConfig), ("door_sensor", DoorSensorConfig), ("door_sensor.leaf", Mark), ("door_sensor.camera", CameraConfig),
)  # fmt: skip
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
    said, made = field_docs(section), []
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


def links_page() -> str:
    """The page of the links' settings."""
    parts = [LINKS_TOP]
    for name, config in LINK_TABLES:
        about = " ".join(str(config.__doc__).split("\n\n")[0].split())
        parts.append(
            f"## `{name}`\n\n`{config.__name__}`: {about}\n\n{HEAD}"
            + "".join(map("{}\n".format, link_rows(name, config)))
        )
    return "\n".join(parts)


def link_rows(table: str, config: type[Any]) -> list[str]:
    """A table's row of every field of a class of settings; fields that are settings of their own have a table of their own.

    Raises:
        SystemExit: if a field has no docstring.
    """
    said, made = field_docs(config), []
    whole = re.search(r"\[([^\]]+)\]\.\Z", str(config.__doc__).strip())
    for field in dataclasses.fields(config):
        if not field.init or field.name in ("timeouts", "rates"):
            continue
        words = WORDS.fullmatch(said.get(field.name, ""))
        if words is None:
            raise SystemExit(f"{config.__name__}.{field.name}: want a docstring that ends with a full stop")
        value = field.default
        default = "required" if value is dataclasses.MISSING else "none" if value is None else f"`{written(value)}`"
        unit = words["unit"] or (whole[1] if whole else "–")
        mark = " ‡" if f"{table}.{field.name}" in GIVEN else ""
        made.append(
            f"| `{field.name}`{mark} | {default} | {unit} | {small(words['meaning']).replace('|', chr(92) + '|')} |"
        )
    return made


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
    LINKS.write_text(links_page(), encoding="utf-8")
    print(f"written: {PAGE.relative_to(ROOT)}, {LINKS.relative_to(ROOT)}")
