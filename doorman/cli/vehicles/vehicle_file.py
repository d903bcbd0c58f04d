"""`doorman vehicle new`, and the calibrations that write into a vehicle file."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import typer

from doorman.cli.overrides import parse_overrides
from doorman.cli.recordings.recorded import chosen_recording
from doorman.cli.terminal.numbers import real_numbers
from doorman.exceptions import DoormanError, RecordingError
from doorman.flight.watches.attitude_loop import recorded_loop
from doorman.hardware.vehicle_file import VehicleFile, vehicle_template, write_values
from doorman.hardware.vehicle_file.calibration import cameras_in_world, object_in_body, servo_zeros
from doorman.kinematics.doors.door import Door
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.recording import Recording
from doorman.scenario import Scenario
from doorman.scenario.files import is_path
from doorman.scenario.toml_text import value_text


def new_file(file: Path, urdf: str, base_link: str, tip: str, every_key: bool) -> int:
    names = {"base_link": base_link, "tip": tip}
    if is_path(urdf) and not Path(urdf).is_file():
        raise DoormanError("no such file", field="--urdf", given=urdf)
    scenario = Scenario.load("paper", {"vehicle.urdf": urdf, **{f"vehicle.{key}": name for key, name in names.items()}})
    vehicle = Vehicle(scenario.vehicle_urdf, scenario.vehicle)
    written = os.path.relpath(urdf, file.parent) if is_path(urdf) else urdf
    written = written if not is_path(urdf) or is_path(written) else f"./{written}"
    text = vehicle_template(file.name, written, vehicle.joint_names, names, every_key)
    try:
        with open(file, "x", encoding="utf-8") as stream:
            stream.write(text)
    except FileExistsError as error:
        raise DoormanError("the file exists already", file=file, allowed="a new one") from error
    typer.echo(f"{file}: {len(vehicle.joint_names)} joints; fill in links and mounting, then calibrate.")
    return 0


def write_zeros(file: Path, posture: str, servos: str | None, as_json: bool) -> int:
    angles = real_numbers(posture, "--posture", posture.count(",") + 1) or ()
    return _write(file, servo_zeros(VehicleFile.load(_own_path(file)), angles, servos), as_json)


def write_object(file: Path, at: str, yaw: float, mocap: str | None, as_json: bool) -> int:
    place = real_numbers(at, "--at", 3) or ()
    if not math.isfinite(yaw):
        raise DoormanError("not an angle", field="--yaw", given=yaw, allowed="a finite number [rad]")
    return _write(file, object_in_body(VehicleFile.load(_own_path(file)), place, yaw, mocap), as_json)


def write_origin(file: Path, hinge: str, latch: str, source: str, settings: Sequence[str], as_json: bool) -> int:
    scenario = VehicleFile.load(_own_path(file)).scenario(source, parse_overrides(settings))
    points = real_numbers(hinge, "--hinge", 3) or (), real_numbers(latch, "--latch", 3) or ()
    return _write(file, cameras_in_world(Door(scenario.door_urdf, scenario.door), *points), as_json)


def write_learned(file: Path, run: Path | None, as_json: bool) -> int:
    vehicle = VehicleFile.load(_own_path(file))
    path = chosen_recording(run)
    recording = Recording.load(path)
    values: dict[str, object] = {}
    if "hover" in recording:
        hover = recording["hover"]
        curve = "pixhawk.thrust_curve"
        values = {
            f"{curve}.hover_thrust": round(float(hover["thrust"][-1]), 4),
            f"{curve}.hover_force": round(float(hover["force"][-1]), 3),
        }
        if "shape" in hover and (float(hover["shape"][-1]) > 0.0 or f"{curve}.shape" in vehicle.values):
            values[f"{curve}.shape"] = round(float(hover["shape"][-1]), 3)
        if f"{curve}.hover_voltage" in vehicle.values:  # else the autopilot compensates the battery
            values[f"{curve}.hover_voltage"] = round(float(hover["voltage"][-1]), 2)
    if "poses" in recording:
        values["mocap.latency"] = round(max(0.0, float(recording["poses"]["latency"][-1])), 4)
    if (loop := recorded_loop(recording)) is not None:
        values["vehicle.attitude_lag"] = round(loop.lag, 3)
        values["vehicle.attitude_dead_time"] = round(loop.dead_time, 3)
    if not values:
        raise RecordingError("measured neither the thrust in hover nor the attitude loop", file=path,
                             allowed="a flight by doorman fly, with attitude setpoints")  # fmt: skip
    return _write(file, values, as_json)


def _own_path(file: Path) -> str:
    """As a path, so that it is never taken for the name of a shipped file."""
    return str(file) if is_path(str(file)) else f"./{file}"


def _write(file: Path, values: Mapping[str, object], as_json: bool) -> int:
    write_values(file, values)
    if as_json:
        typer.echo(json.dumps(values, indent=2))
    else:
        for key, value in values.items():
            typer.echo(f"{file}: {key} = {value_text(value)}")
    return 0
