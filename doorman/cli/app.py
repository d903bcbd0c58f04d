"""The `doorman` command: importing a module of commands registers them; the order here is that of the help."""
# ruff: noqa: I001

from __future__ import annotations

import gc
import signal

import doorman.cli.simulated.commands
import doorman.cli.recordings.commands
import doorman.cli.vehicles.commands
import doorman.cli.setup.commands
import doorman.cli.vehicles.file_commands
import doorman.cli.vehicles.door_commands  # noqa: F401
from doorman.cli.terminal.application import app as app
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
