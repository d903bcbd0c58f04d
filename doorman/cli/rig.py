"""`doorman rig`: everything that `doorman fly` needs but the hardware."""

from __future__ import annotations

import json
import shlex
import signal
import sys
import threading
from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path

import typer

from doorman.cli.overrides import parse_overrides
from doorman.exceptions import BackendError
from doorman.flown import carried_files, recorded_header
from doorman.hardware.scheduling import real_time
from doorman.model import Model
from doorman.recording import Recorder
from doorman.rig import Rig, RigSetup
from doorman.rig.emulated import AutopilotKind
from doorman.scenario import Scenario

_LOOK = 0.2


def run_rig(
    source: str,
    settings: Sequence[str],
    autopilot: AutopilotKind,
    pixhawk_port: int,
    mocap_port: int,
    out: Path | None,
    folder: Path | None = None,
    seed: int = 0,
    as_json: bool = False,
) -> int:
    """Run the rig until Ctrl-C.

    Args:
        source: Name or path of the scenario.
        settings: Overrides, `key=value`.
        autopilot: Who flies the vehicle.
        pixhawk_port: UDP port on loopback that it sends to.
        mocap_port: UDP port on loopback that the cameras send to; 0 for none.
        out: MCAP file for the truth, while the motors run.
        folder: For the link to the servos' pseudo-terminal; a temporary one by default.
        seed: Of noise.
        as_json: Print command and links as JSON.

    Returns:
        Exit status: 0, or 1 if the physics failed.

    Raises:
        DoormanError: if the input cannot be used or a port is taken.
    """
    scenario = Scenario.load(source, parse_overrides(settings))
    setup = RigSetup(autopilot, pixhawk_port, mocap_port, folder, seed=seed)
    header = recorded_header(scenario) | {"rig": autopilot}
    over = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: over.set())
    with (
        nullcontext()
        if out is None
        else Recorder(out, header, keep=False, attachments=carried_files(scenario)) as recorder
    ):
        rig = Rig(Model(scenario), setup, recorder)
        with real_time(), rig:
            overrides = [word for setting in settings for word in ("--set", setting)]
            command = shlex.join(["doorman", "fly", source, *overrides, *rig.arguments])
            links = dict(zip(rig.arguments[::2], rig.arguments[1::2], strict=True))
            other = rig.autopilot_command
            document = {"command": command, "links": {name.strip("-"): one for name, one in links.items()}}
            words = f"The rig runs until Ctrl-C; fly it by\n{command}"
            if rig.pilot is not None and other is not None:
                document["autopilot"] = other
                words = f"Start {rig.pilot.program} in another terminal by\n{other}\n{words}"
            typer.echo(json.dumps(document) if as_json else words)
            sys.stdout.flush()
            while not over.wait(_LOOK) and rig.plant.failure is None:
                pass
        failure = rig.plant.failure
    if failure is not None:
        raise BackendError(f"the plant failed: {failure}")
    return 0
