"""Fuzzes what reads files, scenarios and URDFs: run `python tests/helpers/files_fuzz.py 100000`.

Inputs are the shipped files with characters, lines, words, numbers and tags damaged, doubled, moved or left out, and made
recordings, logs, rows and meshes with bits and stretches damaged. Whatever comes, it is read or refused by a `DoormanError`,
within a time.
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

import numpy as np
from made_logs import tumbling, write_dataflash, write_run, write_ulog
from urdf_variants import DOOR, VEHICLE

import doorman
from doorman.campaign.results import read_parts, write_part
from doorman.exceptions import DoormanError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.urdf.robot import load_pinocchio
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.recording import Recording
from doorman.recording.merging import align, read_log
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


def binary_inputs(folder: Path) -> tuple[tuple[str, Path, Callable[[Path], object]], ...]:
    """Made files of bytes, and what reads them; what is read of a row is the number of rows."""
    rates, rows = tumbling(3), folder / "rows"
    write_run(folder / "run.mcap", rates, 2.5)
    write_ulog(folder / "log.ulg", rates, 0.0, 2.5, 0.0)
    write_dataflash(folder / "log.bin", rates, 0.0, 2.5, 0.0)
    rows.mkdir()
    run = Recording.load(folder / "run.mcap")

    def aligned(path: Path) -> object:
        return align(run, read_log(path))

    write_part({"run": 0, "seed": 1, "success": True, "reason": "opened", "x": 1.5}, rows)
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 0), (1, 0, 0), (0, 0, 1)], dtype="<f4").reshape(2, 9)
    faces = b"".join(bytes(12) + face.tobytes() + bytes(2) for face in corners)
    (folder / "leaf.stl").write_bytes(bytes(80) + (2).to_bytes(4, "little") + faces)
    box = '<box size="1.2 0.04 1.6"/>'
    (folder / "door.urdf").write_text(DOOR.read_text(encoding="utf-8").replace(box, '<mesh filename="leaf.stl"/>'))
    return (
        ("recording", folder / "run.mcap", Recording.load),
        ("ulog", folder / "log.ulg", aligned),
        ("dataflash", folder / "log.bin", aligned),
        ("row", rows / "run-0000000.parquet", _read_row),
        ("mesh", folder / "leaf.stl", lambda _: load_pinocchio(folder / "door.urdf")),
    )


def _read_row(path: Path) -> object:
    if not (rows := read_parts(path.parent)):
        raise DoormanError("no row")
    return rows


def damaged_bytes(data: bytes, chance: random.Random) -> bytes:
    """Bytes with up to three injuries: a flipped bit, a number of 64 bits, a stretch that is missing, doubled or noise."""
    for _ in range(chance.randint(1, 3)):
        at, length = chance.randrange(len(data)), chance.choice((1, 3, 8, 40, 300))
        bit = bytes([data[at] ^ 1 << chance.randrange(8)])
        large = chance.choice((2**63, 2**64 - 1, 10**15, 0)).to_bytes(8, "little")
        same, noise = (data[at : at + length], 0), (chance.randbytes(length), length)
        new, skipped = chance.choice(((bit, 1), (bit, 1), (large, 8), (b"", length), same, noise))
        data = data[:at] + new + data[at + skipped :]
    return data


def damaged(text: str, chance: random.Random) -> str:
    """A text with up to four injuries."""
    for _ in range(chance.randint(1, 4)):
        text = chance.choice((_character, _line, _number, _number, _word, _cut, _moved))(text, chance)
    return text


def damaged_text(data: bytes, chance: random.Random) -> bytes:
    """The same of a file."""
    return damaged(data.decode(), chance).encode(errors="surrogatepass")


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
    inputs = [(*one, damaged_text) for one in READERS]
    inputs += [(*one, damaged_bytes) for one in binary_inputs(folder)]
    for name, source, read, injure in inputs:
        chance, whole = random.Random(f"{seed} {name}"), source.read_bytes()
        path = folder / source.name
        for k in range(count):
            content = injure(whole, chance)
            path.write_bytes(content)
            began = time.perf_counter()
            try:
                read(path)
                counts[f"{name} read"] += 1
            except DoormanError as error:
                assert str(error), content
                counts[f"{name} refused"] += 1
            except Exception as error:
                raise AssertionError(f"{name}, input {k}: {type(error).__name__}: {error}\n{content!r}") from error
            longest = max(longest, time.perf_counter() - began)
            assert longest < LONGEST, content
    counts["longest ms"] = round(1e3 * longest)
    return counts


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        print(dict(fuzz(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 0, Path(folder))))
