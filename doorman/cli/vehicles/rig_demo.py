"""`doorman rig --fly`: rig and flight in one command, each in a process of its own, and what the rig says about the flight."""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from doorman.cli.task import load_task
from doorman.cli.terminal.display import print_run
from doorman.cli.vehicles.flight import fly_mission
from doorman.cli.vehicles.rig import set_options
from doorman.cli.vehicles.served_links import OPTIONS
from doorman.exceptions import BackendError
from doorman.hardware.vehicle_file.file import MOCAP, NO_CAMERAS
from doorman.model import Model
from doorman.recording import Recording
from doorman.rig.witness import judge
from doorman.summary import verdict

_ENTRY = "from doorman.cli import main; main()"


def fly_the_rig(
    source: str,
    settings: list[str] | None,
    autopilot: str,
    out: Path | None,
    seed: int,
    as_json: bool,
    vehicle: str | None = None,
    motors: str = "linear",
) -> int:
    """Start the rig, fly the mission against it over its real links, stop it, and judge."""
    model = Model(load_task(source, settings, vehicle))
    place = out or Path(tempfile.mkdtemp(prefix="doorman-rig-"))
    truth = place if place.suffix and not place.is_dir() else place / "truth.mcap"
    truth.parent.mkdir(parents=True, exist_ok=True)
    flight = truth.with_name("flight.mcap")
    options = ["--autopilot", autopilot, "--motors", motors, "--out", str(truth), "--seed", str(seed)]
    options += set_options(settings)
    if vehicle is None:  # else the ports are the file's
        options += ["--pixhawk-port", str(free_port()), "--mocap-port", str(free_port())]
    else:
        options += ["--vehicle", vehicle]
    with _rig([source, *options]) as links:
        flight.unlink(missing_ok=True)  # of an earlier one
        status = fly_mission(
            source, settings, vehicle, links, flight, None, dry_run=False, yes=True,
            output="quiet" if as_json else "words",
        )  # fmt: skip
    if not flight.exists():
        return 1  # refused on the ground
    recording = Recording.load(flight)
    if "estimate" not in recording:
        return 1  # the mission did not begin
    summary = judge(Recording.load(truth), recording, model)
    good, sentence = verdict(summary)
    print_run(as_json, summary, sentence, place)
    return 0 if good and status == 0 else 1


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@contextmanager
def _rig(arguments: Sequence[str], patience: float = 20.0) -> Iterator[dict[str, object]]:
    """The rig in a process of its own, which ends within a time [s]; yields its links by key of the vehicle file."""
    command = [sys.executable, "-c", _ENTRY, "rig", "--json", *arguments]
    # not in our group: Ctrl-C is the operator's word to the flight, which needs its vehicle until it has landed
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, process_group=0) as process:
        try:
            yield _links(process)
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
                try:
                    process.wait(patience)
                except subprocess.TimeoutExpired:
                    process.kill()
                    raise BackendError("the rig does not stop", given=f"{patience:g} s") from None


def _links(process: subprocess.Popen[str]) -> dict[str, object]:
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("{"):
            links = {OPTIONS[f"--{name}"]: link for name, link in json.loads(line)["links"].items()}
            return {MOCAP: NO_CAMERAS, **links}
    raise BackendError("the rig did not start: see its message above")
