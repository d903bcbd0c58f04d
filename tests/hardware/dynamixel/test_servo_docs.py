"""The program of docs/hardware/servos.md runs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from servo_rig import Rig

from doorman.clocks import REAL_TIME

PAGE = (Path(__file__).parents[3] / "docs" / "hardware" / "servos.md").read_text(encoding="utf-8")


def test_the_program_of_the_page_runs(make_emulator):
    emulator = make_emulator(clock=REAL_TIME)
    (program,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    program = re.sub(r'port="[^"]*"', f"port={emulator.port!r}", program)
    names: dict[str, object] = {}
    exec(compile(program, "servos.md", "exec"), names)
    assert names["sample"].angles == pytest.approx([0.0] * 4, abs=1e-9)  # type: ignore[attr-defined]
    rig = Rig(emulator, names["config"])  # type: ignore[arg-type]
    assert [rig.row(servo_id, "goal velocity") for servo_id in (1, 2, 3, 4)] == [0, 0, 0, 0]
