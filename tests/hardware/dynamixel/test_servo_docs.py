"""What docs/hardware/servos.md says: its rows are tests, its names exist, its numbers are those of the code."""

from __future__ import annotations

import ast
import re
from dataclasses import fields
from pathlib import Path

import pytest
from servo_rig import Rig

from doorman.clocks import REAL_TIME
from doorman.hardware.dynamixel import ServoConfig, ServoFault
from doorman.hardware.dynamixel.setup.settings import SETTINGS, TOLERATED_RETURN_DELAY
from doorman.hardware.dynamixel.wire.registers import OLDEST_FIRMWARE, STARTUP_FIRMWARE
from doorman.hardware.dynamixel.wire.units import VELOCITY_UNIT
from doorman.rig.emulators.servos.table import ITEMS

HERE = Path(__file__).parent
PAGE = (HERE.parents[2] / "docs" / "hardware" / "servos.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """Rows below a heading, without the table's head."""
    part = PAGE.split(f"\n## {heading}\n", 1)[1].split("\n## ", 1)[0]
    lines = [line for line in part.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


def names_of_tests() -> set[str]:
    return {
        node.name
        for path in HERE.glob("test_*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    }


def test_every_row_of_the_fault_table_is_a_test():
    rows = table("Faults")
    assert len(rows) >= 25
    assert {re.fullmatch(r"`(\w+)`", row[-1]).group(1) for row in rows} <= names_of_tests()
    assert all(len(row) == 6 and all(row) for row in rows)


def test_every_fault_is_in_the_table():
    told = {name for row in table("Faults") for name in re.findall(r"[A-Z_]{3,}", row[1])}
    assert told == {fault.name for fault in ServoFault}


def test_every_setting_is_in_the_table():
    names = [row[0] for row in table("Settings verified")]
    assert all(name in ITEMS for name in names)
    assert set(SETTINGS) | {"model number", "firmware version"} == set(names)


def test_names_of_the_configuration_exist():
    known = {field.name for field in fields(ServoConfig)}
    used = set(re.findall(r"`(\w+)`", PAGE.split("## Wiring and set-up")[1].split("## Why")[0]))
    known |= {
        "open",
        "stop",
        "read",
        "command",
        "recover",
        "inspect",
        "grip",
        "with",
        "STOPPING",
        "LATCHED",
        "WARNINGS",
    }
    assert {name for name in used if not name.startswith("test_")} <= known


def test_numbers_are_those_of_the_code():
    config = ServoConfig("nowhere", [-1.0] * 4, [1.0] * 4, [3.0] * 4)
    assert f"{config.rate:g} times a second" in PAGE
    assert f"| a cycle | {config.period * 1e3:g} ms |" in PAGE
    assert f"{VELOCITY_UNIT:.3f} rad/s" in PAGE
    times = {row[1]: row[2] for row in table("Faults")}
    slow_cycle, probing_cycle = 15.0, 20.0
    stale, missing = config.stale_after * 1e3 + slow_cycle, config.missing_after * 1e3 + probing_cycle
    assert times["STALE, MISSING"] == f"{stale:g} ms, {missing:g} ms"
    assert times["LATE, STALE"] == f"{stale:g} ms"
    assert times["COMMAND_STALE"] == f"{config.command_timeout * 1e3:g} ms"
    assert times["STRAINED"] == f"{config.strain_time:g} s"
    assert f"after {config.watchdog * 1e3:g} ms" in PAGE
    settings = {row[0]: row for row in table("Settings verified")}
    assert settings["firmware version"][1].startswith(str(OLDEST_FIRMWARE))
    assert f"from firmware {STARTUP_FIRMWARE} on" in settings["startup configuration"][1]
    assert f"above {TOLERATED_RETURN_DELAY} refused" in settings["return delay time"][2]


def test_the_program_of_the_page_runs(make_emulator):
    emulator = make_emulator(clock=REAL_TIME)
    (program,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    program = re.sub(r'port="[^"]*"', f"port={emulator.port!r}", program)
    names: dict[str, object] = {}
    exec(compile(program, "servos.md", "exec"), names)
    assert names["sample"].angles == pytest.approx([0.0] * 4, abs=1e-9)  # type: ignore[attr-defined]
    rig = Rig(emulator, names["config"])  # type: ignore[arg-type]
    assert [rig.row(servo_id, "goal velocity") for servo_id in (1, 2, 3, 4)] == [0, 0, 0, 0]
