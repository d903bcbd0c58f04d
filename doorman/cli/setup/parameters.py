"""`doorman parameters`: a parameter file for the autopilot of a scenario's vehicle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import typer

from doorman import __version__
from doorman.cli.overrides import parse_overrides
from doorman.exceptions import DoormanError
from doorman.hardware.pixhawk import PixhawkConfig
from doorman.hardware.pixhawk.parameters.file import (
    AutopilotName,
    OnLoss,
    Port,
    VehicleFigures,
    as_text,
    parameter_lines,
)
from doorman.hardware.vehicle import Places
from doorman.hardware.vehicle_file import VehicleFile
from doorman.model import Model

LONGEST_DELAY = 0.25
"""Longest delay that ArduPilot accepts [s]."""


def print_parameters(
    autopilot: AutopilotName,
    source: str,
    settings: Sequence[str],
    mocap: bool | None,
    on_loss: OnLoss,
    mocap_delay: float | None,
    vehicle: str | None = None,
    port: Port | None = None,
) -> int:
    if mocap_delay is not None and not (math.isfinite(mocap_delay) and 0.0 <= mocap_delay <= LONGEST_DELAY):
        raise DoormanError(
            "out of range", field="--mocap-delay", given=mocap_delay, allowed=f"0 to {LONGEST_DELAY:g} s"
        )
    file = VehicleFile() if vehicle is None else VehicleFile.load(vehicle)
    model = Model(file.scenario(source, parse_overrides(settings)))
    places = Places.of(model)
    figures = VehicleFigures(
        model.vehicle.weight, model.vehicle.max_thrust, model.scenario.safety.low_battery,
        float(places.hover[2] - places.pad[2]),
    )  # fmt: skip
    config = PixhawkConfig("udp:14540", mocap=True, hover_force=figures.weight)
    if vehicle is not None:
        config = file.links_anywhere(model).pixhawk
    config = config if mocap is None else replace(config, mocap=mocap)
    lines = parameter_lines(autopilot, config, figures, on_loss, mocap_delay, port)
    title = f"doorman {__version__}: {autopilot} for scenario {model.scenario.name}, {model.vehicle.mass:.2f} kg"
    typer.echo(as_text(autopilot, lines, title), nl=False)
    return 0
