"""Fuzzes what reads files, scenarios and URDFs: run `python tests/files_fuzz.py 100000`.

Inputs are the shipped files with characters, lines, words, numbers and tags damaged, doubled, moved or left out. Whatever comes,
it is read or refused by a `DoormanError`, within a time.
"""

from __future__ import annotations

import random
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from urdf_variants import DOOR, VEHICLE

import doorman
from doorman.exceptions import DoormanError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.scenario import Scenario

LONGEST = 5.0
"""Nothing takes longer, on a busy computer [s]."""
_SCENARIOS = sorted((Path(doorman.__file__).parent / "scenarios").glob("*.toml"))
_NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
_WORD = re.compile(r"\w+")
_ODD = (
    "0", "-0.0", "-1", "1e160", "-1e300", "1e-300", "1e999", "nan", "inf", "-inf", "0x10", "1_0", "true", "[]", "{}", '""', "'",
    "",
)  # fmt: skip
_NOISE = "\x00\t\n \"'#<>&;=[]{}().,-+eE0123456789äπ\u2028\ud7ff\U0001f6aa"

READERS: tuple[tuple[str, Path, Callable[[Path], object]], ...] = (
    *((path.name, path, Scenario.load) for path in _SCENARIOS),
    ("door", DOOR, Door),
    ("vehicle", VEHICLE, Vehicle),
)


def damaged(text: str, chance: random.Random) -> str:
    """A text with up to four injuries."""
    for _ in range(chance.randint(1, 4)):
        text = chance.choice((_character, _line, _number, _number, _word, _cut, _moved))(text, chance)
    return text


def _character(text: str, chance: random.Random) -> str:
    at = chance.randrange(len(text) + 1)
    return text[:at] + chance.choice(_NOISE) + text[at + chance.randint(0, 2) :]


def _line(text: str, chance: random.Random) -> str:
    lines = text.split("\n")
    at = chance.randrange(len(lines))
    return "\n".join([*lines[:at], *[lines[at]] * chance.choice((0, 2)), *lines[at + 1 :]])


def _replaced(text: str, chance: random.Random, pattern: re.Pattern[str], news: tuple[str, ...]) -> str:
    found = list(pattern.finditer(text))
    if not found:
        return text
    one = chance.choice(found)
    return text[: one.start()] + chance.choice(news) + text[one.end() :]


def _number(text: str, chance: random.Random) -> str:
    return _replaced(text, chance, _NUMBER, (*_ODD, str(chance.uniform(-10.0, 10.0)), str(chance.randint(-5, 10**9))))


def _word(text: str, chance: random.Random) -> str:
    words = _WORD.findall(text) or ["x"]
    return _replaced(text, chance, _WORD, (chance.choice(words), "x" * 300, *_ODD))


def _cut(text: str, chance: random.Random) -> str:
    first, last = sorted(chance.randrange(len(text) + 1) for _ in range(2))
    return text if last - first > 400 else text[:first] + text[last:]


def _moved(text: str, chance: random.Random) -> str:
    lines = text.split("\n")
    first, second = (chance.randrange(len(lines)) for _ in range(2))
    lines[first], lines[second] = lines[second], lines[first]
    return "\n".join(lines)


def fuzz(count: int, seed: int, folder: Path) -> Counter[str]:
    """Read so many damaged files of every kind.

    Returns:
        How many were read and refused, by kind.

    Raises:
        AssertionError: if something else than a `DoormanError` is raised, or it takes too long; it has the input.
    """
    counts: Counter[str] = Counter()
    longest = 0.0
    for name, source, read in READERS:
        chance, text = random.Random(f"{seed} {name}"), source.read_text(encoding="utf-8")
        path = folder / source.name
        for k in range(count):
            content = damaged(text, chance)
            path.write_text(content, encoding="utf-8")
            began = time.perf_counter()
            try:
                read(path)
                counts[f"{name} read"] += 1
            except DoormanError as error:
                assert str(error), content
                counts[f"{name} refused"] += 1
            except Exception as error:
                raise AssertionError(f"{name}, input {k}: {type(error).__name__}: {error}\n{content}") from error
            longest = max(longest, time.perf_counter() - began)
            assert longest < LONGEST, content
    counts["longest ms"] = round(1e3 * longest)
    return counts


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        print(dict(fuzz(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0, Path(folder))))
