"""The `doorman` command: importing a module of commands registers them; the order here is that of the help."""

# ruff: noqa: I001, F401
from __future__ import annotations

import gc
import signal

import doorman.cli.simulated.check
import doorman.cli.simulated.listing
import doorman.cli.simulated.warmup
import doorman.cli.simulated.open_door
import doorman.cli.simulated.campaign
import doorman.cli.recordings.pictures
import doorman.cli.recordings.export
import doorman.cli.recordings.replay
import doorman.cli.recordings.estimate
import doorman.cli.recordings.merge
import doorman.cli.vehicles.rig
import doorman.cli.vehicles.fly
import doorman.cli.setup.parameters
import doorman.cli.setup.doctor
import doorman.cli.setup.ros2
import doorman.cli.vehicles.vehicle_file
import doorman.cli.vehicles.door
from doorman.cli.command import app as app
from doorman.cli.terminal.streams import steady_streams

_COLLECTIONS = 50_000, 20, 100
"""Python's thresholds of garbage collection: with its own, imports spend an eighth of their time looking for what is none."""


def main() -> None:
    steady_streams()
    gc.set_threshold(*_COLLECTIONS)
    try:
        app(prog_name="doorman")
    finally:  # from here on Ctrl-C ends the process without a word
        signal.signal(signal.SIGINT, signal.SIG_DFL)
