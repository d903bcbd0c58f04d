"""`doorman rig`: everything that `doorman fly` needs but the hardware."""

from __future__ import annotations

import json
import shlex
import signal
import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Literal

import typer

from doorman.cli.command import VEHICLE, command
from doorman.cli.options import Json, Settings, Source, Vehicle, flag, valued
from doorman.exceptions import BackendError


@command(VEHICLE)
def rig(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    autopilot: Annotated[
        Literal["px4", "ardupilot", "px4-sitl", "ardupilot-sitl"],
        typer.Option(help="Autopilot to emulate; for px4-sitl and ardupilot-sitl you start the autopilot's own code."),
    ] = "px4",
    motors: Annotated[
        Literal["linear", "quadratic"],
        typer.Option(
            help="linear: the autopilot linearises the motors; quadratic: thrust is the signal squared, 40 ms late."
        ),
    ] = "linear",
    pixhawk_port: Annotated[
        int | None, valued(None, "UDP port on loopback for the autopilot.", "the vehicle file's, or 14540")
    ] = None,
    mocap_port: Annotated[
        int | None, valued(None, "UDP port for the cameras; 0: no cameras.", "the vehicle file's, or 51001")
    ] = None,
    out: Annotated[
        Path | None, valued("FILE", "MCAP file for the ground truth; with --fly also a folder for truth and flight.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the noise.")] = 0,
    fly: Annotated[bool, flag("--fly", "Fly the mission against the rig, judge the flight, and exit.")] = False,
    judge: Annotated[bool, flag("--judge", "After Ctrl-C, judge by the truth what was flown against the rig.")] = False,
    as_json: Json = False,
) -> int:
    """Emulate autopilot, servos and cameras around one simulated vehicle and door.

    The emulators use the protocols of the real devices, on loopback and on a pseudo-terminal. The command prints the command
    that flies the mission from another terminal, and runs until Ctrl-C. With --fly it also flies the mission; with --judge
    it judges what others fly, behind an autopilot's own code, too. The exit status is then 0 only if the door is open,
    without a collision, and the vehicle has landed.

    With --vehicle, servos and object have the mounting of the vehicle file, so that a dry run shows whether everything
    matches. If a link of the file is on loopback, or a path outside /dev, the rig creates it there. The printed command has
    options for all other links.
    """
    if fly:
        if judge:
            raise typer.BadParameter("--fly judges the flight by itself", param_hint="--judge")
        if autopilot.endswith("-sitl"):
            raise typer.BadParameter(f"you start {autopilot} yourself: run the rig without --fly", param_hint="--fly")
        from doorman.cli.vehicles.rig_demo import fly_the_rig

        return fly_the_rig(scenario, settings, autopilot, out, seed, as_json, vehicle, motors)
    from doorman.cli.values import parse_overrides
    from doorman.cli.vehicles.served_links import other_links, served_device, served_port
    from doorman.flown import carried_files, recorded_header
    from doorman.hardware.scheduling import real_time
    from doorman.hardware.vehicle_file import VehicleFile
    from doorman.hardware.vehicle_file.file import MOCAP, PIXHAWK
    from doorman.model import Model
    from doorman.recording import Recorder
    from doorman.rig import Rig, RigSetup
    from doorman.rig.witness import Witness, verdict

    file = VehicleFile() if vehicle is None else VehicleFile.load(vehicle)
    task = file.scenario(scenario, parse_overrides(settings))
    model = Model(task)
    setup = RigSetup(
        autopilot, served_port(file, PIXHAWK, pixhawk_port, 14540), served_port(file, MOCAP, mocap_port, 51001), None,
        vehicle=None if vehicle is None else file.links_anywhere(model), servos=served_device(file), seed=seed,
        motors=motors,
    )  # fmt: skip
    header = recorded_header(task) | {"rig": autopilot, "motors": motors}
    witness = Witness(model)
    signals: list[int] = []  # no Event: this thread would wait for its own lock where the signal finds it in `wait`
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _: signals.append(number))
    with (
        nullcontext()
        if out is None and not judge
        else Recorder(out, header, witness.note, keep=False, attachments=carried_files(task)) as recorder
    ):
        emulated = Rig(model, setup, recorder)
        with real_time(), emulated:
            links = dict(zip(emulated.arguments[::2], emulated.arguments[1::2], strict=True))
            options = [] if vehicle is None else ["--vehicle", vehicle, *other_links(file, links)]
            words = ["doorman", "fly", scenario, *set_options(settings), *(options or emulated.arguments)]
            document = {"command": shlex.join(words), "links": {name.strip("-"): one for name, one in links.items()}}
            line = f"The rig runs until Ctrl-C; fly it with\n{document['command']}"
            if emulated.pilot is not None and (other := emulated.autopilot_command) is not None:
                document["autopilot"] = other
                line = f"Start {emulated.pilot.program} in another terminal with\n{other}\n{line}"
            typer.echo(json.dumps(document) if as_json else line)
            sys.stdout.flush()
            while not signals and emulated.plant.failure is None:
                time.sleep(0.2)
        failure = emulated.plant.failure
    if failure is not None:
        raise BackendError(f"the plant failed: {failure}")
    if not judge:
        return 0
    figures = witness.judged(emulated.plant.snapshot)
    good, sentence = verdict(figures)
    typer.echo(json.dumps(figures) if as_json else sentence)
    if as_json:
        typer.echo(sentence, err=True)
    return 0 if good else 1


def set_options(settings: list[str] | None) -> list[str]:
    """Overrides as a command writes them."""
    return [word for setting in settings or () for word in ("--set", setting)]
