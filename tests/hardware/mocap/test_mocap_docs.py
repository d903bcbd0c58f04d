"""The example of docs/hardware/mocap.md runs."""

from __future__ import annotations

import re

from mocap_rig import free_port, swaying
from mocap_table import PAGE

from doorman.rig.emulators.mocap.emulator import MocapEmulator, TrackerSetup


def test_the_example_runs(capsys):
    code = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1]
    port = free_port()
    code = code.replace("udp:192.168.10.7:51001", f"udp:{port}")
    setup = TrackerSetup("hexarotor", object_position=(0.0, 0.0, 0.06))
    with MocapEmulator(swaying, setup, ("127.0.0.1", port)):
        exec(compile(code, "docs/hardware/mocap.md", "exec"), {})
    assert "mocap: object acquired" in capsys.readouterr().out
