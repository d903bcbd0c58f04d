"""The program of docs/hardware/pixhawk.md runs."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from pixhawk_rig import free_port

HERE = Path(__file__).parent
PAGE = (HERE.parents[2] / "docs" / "hardware" / "pixhawk.md").read_text(encoding="utf-8")


def test_the_program_runs():
    (program,) = re.findall(r"^```python\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    program = program.replace("14540", str(free_port()))
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert run.returncode == 0, run.stderr
    assert "COM_OBL_RC_ACT is 0 and must be 4" in run.stdout and run.stdout.rstrip().endswith("engaged")
