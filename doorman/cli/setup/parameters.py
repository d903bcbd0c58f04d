"""`doorman parameters`: a parameter file for the autopilot of a scenario's vehicle."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import typer

from doorman.cli.command import VEHICLE, command
from doorman.cli.options import Settings, Source, Vehicle, flag, valued
from doorman.exceptions import DoormanError


@command(VEHICLE)
def parameters(
    autopilot: Annotated[Literal["px4", "ardupilot"], typer.Argument(help="Firmware of the autopilot.")],
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    mocap: Annotated[
        bool | None,
        valued(
            None, "Whether poses come from cameras.", "the vehicle file's; yes without a file", "--mocap/--no-mocap"
        ),
    ] = None,
    on_loss: Annotated[
        Literal["land", "return"],
        typer.Option(help="What the autopilot does when this computer is silent: land in place, or on its pad."),
    ] = "land",
    mocap_delay: Annotated[
        float | None, valued("SECONDS", "Delay of poses from exposure to sending; for ArduPilot.", "omitted")
    ] = None,
    telem: Annotated[int, typer.Option(min=0, max=3, help="Telemetry port that connects this computer; 0: USB.")] = 2,
    baud: Annotated[int, typer.Option(help="Baud rate of that port.")] = 921_600,
    flow_control: Annotated[
        bool, flag("--flow-control/--no-flow-control", "Whether RTS and CTS are also wired.")
    ] = False,
) -> int:
    """Print a parameter file for the autopilot of a scenario's vehicle: doorman parameters px4 > vehicle.params.

    A comment gives the reason of every line. The file contains the parameters that the checklist of doorman fly verifies,
    those of the telemetry port, and a first guess of the hover thrust. Load it with a ground station; for PX4 it has the
    format of QGroundControl.
    """
    from doorman import __version__
    from doorman.cli.values import parse_overrides
    from doorman.hardware.pixhawk import PixhawkConfig
    from doorman.hardware.pixhawk.parameters.file import Port, VehicleFigures, as_text, parameter_lines
    from doorman.hardware.vehicle import Places
    from doorman.hardware.vehicle_file import VehicleFile
    from doorman.model import Model

    if mocap_delay is not None and not 0.0 <= mocap_delay <= 0.25:  # ArduPilot accepts no longer one
        raise DoormanError("out of range", field="--mocap-delay", given=mocap_delay, allowed="0 to 0.25 s")
    file = VehicleFile() if vehicle is None else VehicleFile.load(vehicle)
    model = Model(file.scenario(scenario, parse_overrides(settings)))
    places = Places.of(model)
    figures = VehicleFigures(
        model.vehicle.weight, model.vehicle.max_thrust, model.scenario.safety.low_battery,
        float(places.hover[2] - places.pad[2]),
    )  # fmt: skip
    config = PixhawkConfig("udp:14540", mocap=True, hover_force=figures.weight)
    if vehicle is not None:
        config = file.links_anywhere(model).pixhawk
    config = config if mocap is None else replace(config, mocap=mocap)
    port = Port(telem, baud, flow_control)
    lines = parameter_lines(autopilot, config, figures, on_loss, mocap_delay, port)
    title = f"doorman {__version__}: {autopilot} for scenario {model.scenario.name}, {model.vehicle.mass:.2f} kg"
    typer.echo(as_text(autopilot, lines, title), nl=False)
    return 0
