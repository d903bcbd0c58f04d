"""`doorman rig`: everything that `doorman fly` needs but the hardware."""

from __future__ import annotations

import json
import shlex
import signal
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path

import typer

from doorman.cli.overrides import parse_overrides
from doorman.exceptions import BackendError
from doorman.flown import carried_files, recorded_header
from doorman.hardware.pixhawk.wire.connection import Transport, parse_connection
from doorman.hardware.scheduling import real_time
from doorman.hardware.vehicle_file import VehicleFile
from doorman.hardware.vehicle_file.file import MOCAP, NO_CAMERAS, PIXHAWK, SERVOS
from doorman.model import Model
from doorman.recording import Recorder
from doorman.rig import Rig, RigSetup
from doorman.rig.emulated import AutopilotKind
from doorman.rig.emulators.autopilot.dialects import MotorKind
from doorman.rig.witness import Witness, verdict

_LOOK = 0.2
_LISTENS_ON_LOOPBACK = ("127.0.0.1", "0.0.0.0")
OPTIONS = {"--pixhawk": PIXHAWK, "--servos": SERVOS, "--mocap": MOCAP}
"""Key of the vehicle file by option of `doorman fly`."""


def run_rig(
    source: str,
    settings: Sequence[str],
    autopilot: AutopilotKind,
    pixhawk_port: int | None,
    mocap_port: int | None,
    out: Path | None,
    folder: Path | None = None,
    seed: int = 0,
    as_json: bool = False,
    vehicle: str | None = None,
    motors: MotorKind = "linear",
    judges: bool = False,
) -> int:
    """Run the rig until Ctrl-C; then say what the flight was, if asked to."""
    file = VehicleFile() if vehicle is None else VehicleFile.load(vehicle)
    scenario = file.scenario(source, parse_overrides(settings))
    model = Model(scenario)
    setup = RigSetup(
        autopilot, served_port(file, PIXHAWK, pixhawk_port, 14540), served_port(file, MOCAP, mocap_port, 51001), folder,
        vehicle=None if vehicle is None else file.links_anywhere(model), servos=served_device(file), seed=seed,
        motors=motors,
    )  # fmt: skip
    header = recorded_header(scenario) | {"rig": autopilot, "motors": motors}
    witness = Witness(model)
    signals: list[int] = []  # no Event: this thread would wait for its own lock where the signal finds it in `wait`
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _: signals.append(number))
    with (
        nullcontext()
        if out is None and not judges
        else Recorder(out, header, witness.note, keep=False, attachments=carried_files(scenario)) as recorder
    ):
        rig = Rig(model, setup, recorder)
        with real_time(), rig:
            overrides = [word for setting in settings for word in ("--set", setting)]
            links = dict(zip(rig.arguments[::2], rig.arguments[1::2], strict=True))
            options = [] if vehicle is None else ["--vehicle", vehicle, *other_links(file, links)]
            command = shlex.join(["doorman", "fly", source, *overrides, *(options or rig.arguments)])
            other = rig.autopilot_command
            document = {"command": command, "links": {name.strip("-"): one for name, one in links.items()}}
            words = f"The rig runs until Ctrl-C; fly it with\n{command}"
            if rig.pilot is not None and other is not None:
                document["autopilot"] = other
                words = f"Start {rig.pilot.program} in another terminal with\n{other}\n{words}"
            typer.echo(json.dumps(document) if as_json else words)
            sys.stdout.flush()
            while not signals and rig.plant.failure is None:
                time.sleep(_LOOK)
        failure = rig.plant.failure
    if failure is not None:
        raise BackendError(f"the plant failed: {failure}")
    return _judge(witness, rig, as_json) if judges else 0


def _judge(witness: Witness, rig: Rig, as_json: bool) -> int:
    """Print what the truth shows; returns the exit status."""
    figures = witness.judged(rig.plant.snapshot)
    good, sentence = verdict(figures)
    typer.echo(json.dumps(figures) if as_json else sentence)
    if as_json:
        typer.echo(sentence, err=True)
    return 0 if good else 1


def served_port(file: VehicleFile, key: str, given: int | None, usual: int) -> int:
    """UDP port on loopback that an emulator sends to."""
    connection = file.values.get(key)
    if given is not None or connection is None:
        return usual if given is None else given
    if connection == NO_CAMERAS:
        return 0
    try:
        endpoint = parse_connection(connection)
    except BackendError:  # cameras with a protocol of their own
        return usual
    listens = endpoint.transport is Transport.UDP_LISTEN and endpoint.host in _LISTENS_ON_LOOPBACK
    return endpoint.port if listens else usual


def served_device(file: VehicleFile) -> Path | None:
    """Where the vehicle file has the servos, if a link to a pseudo-terminal can be made there."""
    device = file.values.get(SERVOS)
    return None if device is None or Path(device).is_relative_to("/dev") else Path(device)


def other_links(file: VehicleFile, links: Mapping[str, str]) -> list[str]:
    """Options of `doorman fly` for the links that are elsewhere than the vehicle file says."""
    options = [
        word
        for option, link in links.items()
        for word in (option, link)
        if not _same(file.values.get(OPTIONS[option]), link)
    ]
    without = "--mocap" not in links and file.values.get(MOCAP) not in (None, NO_CAMERAS)
    return [*options, "--mocap", NO_CAMERAS] if without else options


def _same(named: str | None, link: str) -> bool:
    """Whether the vehicle file names this link, which listens on loopback if it is a port."""
    if named is None or not link.startswith("udp:"):
        return named == link
    try:
        endpoint = parse_connection(named)
    except BackendError:
        return False
    return (
        endpoint.transport is Transport.UDP_LISTEN
        and f"udp:{endpoint.port}" == link
        and endpoint.host in _LISTENS_ON_LOOPBACK
    )
