"""The page on the Pixhawk: its program runs, its connections are understood, its parameters are those of the check."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from pixhawk_rig import free_port

from doorman.hardware.pixhawk import PixhawkConfig, ThrustCurve
from doorman.hardware.pixhawk.dialect import ARDUPILOT, PX4
from doorman.hardware.pixhawk.parameters.rules import rules_for
from doorman.hardware.pixhawk.wire.connection import parse_connection

HERE = Path(__file__).parent
PAGE = (HERE.parents[2] / "docs" / "hardware" / "pixhawk.md").read_text(encoding="utf-8")


def table(heading: str) -> list[list[str]]:
    """Rows of the first table below a heading."""
    text = PAGE.split(f"{heading}\n", 1)[1]
    lines = re.search(r"(?:^\|.*\n)+", text, re.MULTILINE)
    assert lines is not None
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[0].splitlines()[2:]]


def test_the_program_runs():
    (program,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    program = program.replace("14540", str(free_port()))
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 0, run.stderr
    assert "COM_OBL_RC_ACT is 0 and must be 4" in run.stdout and run.stdout.rstrip().endswith("engaged")


def test_connection_strings_of_the_table_are_understood():
    for strings, _ in table("## Connection"):
        for text in re.findall(r"`([^`]+)`", strings):
            parse_connection(text.replace("HOST", "localhost").replace("PORT", "5760").replace("OURS", "5761"))


def test_the_table_of_parameters_is_that_of_the_check():
    config = PixhawkConfig("udp:14540", mocap=True, thrust_curve=ThrustCurve(0.4, 30.0, hover_voltage=15.0))
    expected = []
    for dialect in (PX4, ARDUPILOT):
        for rule in rules_for(dialect, config, 0.01):
            wanted = "the measured delay" if rule.names[0] == "VISO_DELAY_MS" else rule.wanted
            expected.append([dialect.name, f"`{rule.names[0]}`", wanted, rule.condition, rule.why])
    assert table("### Parameters") == expected
