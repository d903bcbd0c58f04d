"""`doorman vehicle`: the commands that write a vehicle file, and calibrations into it."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from doorman.cli.command import VEHICLE, app, command
from doorman.cli.options import Json, Settings, Source, flag, valued
from doorman.exceptions import DoormanError, RecordingError

if TYPE_CHECKING:  # commands import what they run when they run it
    from doorman.hardware.vehicle_file import VehicleFile

_File = Annotated[Path, typer.Argument(metavar="FILE", help="The vehicle file; the command keeps its comments.")]
group = typer.Typer(
    help="Write a vehicle file and add calibrations to it: URDF, links, servos, cameras, thrust.", no_args_is_help=True
)
app.add_typer(group, name="vehicle", rich_help_panel=VEHICLE)


@command(group=group)
def new(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="New file to write.")],
    urdf: Annotated[
        str, valued("URDF", "URDF of the vehicle: a path, or the name of a shipped one.")
    ] = "hexarotor_arm",
    base_link: Annotated[str, valued("LINK", "Base link of the multirotor.")] = "base_link",
    tip: Annotated[str, valued("FRAME", "Frame of the arm's tip.")] = "tip",
    every_key: Annotated[bool, flag("--all", "Also write all other keys and their defaults, as comments.")] = False,
) -> int:
    """Write a vehicle file with comments, for you to fill in.

    Its servos are those of the URDF's arm, then a gripper's.
    """
    from doorman.hardware.vehicle_file import vehicle_template
    from doorman.kinematics.vehicles.vehicle import Vehicle
    from doorman.scenario import Scenario
    from doorman.scenario.files import is_path

    names = {"base_link": base_link, "tip": tip}
    if is_path(urdf) and not Path(urdf).is_file():
        raise DoormanError("no such file", field="--urdf", given=urdf)
    scenario = Scenario.load("paper", {"vehicle.urdf": urdf, **{f"vehicle.{key}": name for key, name in names.items()}})
    joints = Vehicle(scenario.vehicle_urdf, scenario.vehicle).joint_names
    written = os.path.relpath(urdf, file.parent) if is_path(urdf) else urdf
    written = written if not is_path(urdf) or is_path(written) else f"./{written}"
    try:
        with open(file, "x", encoding="utf-8") as stream:
            stream.write(vehicle_template(file.name, written, joints, names, every_key))
    except FileExistsError as error:
        raise DoormanError("the file exists already", file=file, allowed="a new one") from error
    typer.echo(f"{file}: {len(joints)} joints; fill in links and mounting, then calibrate.")
    return 0


@command(group=group)
def zeros(
    file: _File,
    posture: Annotated[str, valued("ANGLES", "Angles of all joints, then of the gripper, as in the URDF [rad].")],
    servos: Annotated[str | None, valued("DEVICE", "Serial device of the servos.", "the file's")] = None,
    as_json: Json = False,
) -> int:
    """Read the servos' positions and write the zeros of their joints.

    Hold the arm in a known posture, with torque off as after power-on. The directions in the file must already be right.
    """
    from doorman.cli.values import real_numbers
    from doorman.hardware.vehicle_file.calibration import servo_zeros

    angles = real_numbers(posture, "--posture", posture.count(",") + 1) or ()
    return _write(file, servo_zeros(_loaded(file), angles, servos), as_json)


@command(group=group, name="object")
def object_(
    file: _File,
    at: Annotated[str, valued("X,Y,Z", "Position of O_B in the world [m], by plumb line.")],
    yaw: Annotated[float, valued("ANGLE", "Heading of the vehicle [rad].")] = 0.0,
    mocap: Annotated[str | None, valued("LINK", "Link to the cameras.", "the file's")] = None,
    as_json: Json = False,
) -> int:
    """Measure the tracked object with the cameras, and write its pose in the body.

    Put the vehicle down level at a known position. Write the cameras' axes first: doorman vehicle origin.
    """
    from doorman.cli.values import real_numbers
    from doorman.hardware.vehicle_file.calibration import object_in_body

    place = real_numbers(at, "--at", 3) or ()
    if not math.isfinite(yaw):
        raise DoormanError("not an angle", field="--yaw", given=yaw, allowed="a finite number [rad]")
    return _write(file, object_in_body(_loaded(file), place, yaw, mocap), as_json)


@command(group=group)
def origin(
    file: _File,
    hinge: Annotated[str, valued("X,Y,Z", "Lower end of the hinge line [m].")],
    latch: Annotated[str, valued("X,Y,Z", "Lower end of the closed leaf's free edge [m].")],
    scenario: Source = "paper",
    settings: Settings = None,
    as_json: Json = False,
) -> int:
    """Write the pose of the cameras' axes in the world, from two points of the closed door, measured in these axes.

    The door is that of the scenario. Its URDF defines the world.
    """
    from doorman.cli.values import parse_overrides, real_numbers
    from doorman.hardware.vehicle_file.calibration import cameras_in_world
    from doorman.kinematics.doors.door import Door

    task = _loaded(file).scenario(scenario, parse_overrides(settings))
    points = real_numbers(hinge, "--hinge", 3) or (), real_numbers(latch, "--latch", 3) or ()
    return _write(file, cameras_in_world(Door(task.door_urdf, task.door), *points), as_json)


@command(group=group)
def learn(
    file: _File,
    run: Annotated[
        Path | None,
        typer.Argument(
            metavar="[RUN]",
            help="Folder or recording of a flight by doorman fly.",
            show_default="the newest run under runs",
        ),
    ] = None,
    as_json: Json = False,
) -> int:
    """Write measurements of a flight: thrust in hover, latency of the poses, lag of the attitude."""
    from doorman.cli.recordings.recorded import chosen_recording
    from doorman.flown import recorded_loop
    from doorman.recording import Recording

    vehicle, path = _loaded(file), chosen_recording(run)
    recording = Recording.load(path)
    values: dict[str, object] = {}
    if "hover" in recording:
        hover, curve = {name: float(found[-1]) for name, found in recording["hover"].items()}, "pixhawk.thrust_curve"
        values[f"{curve}.hover_thrust"] = round(hover["thrust"], 4)
        values[f"{curve}.hover_force"] = round(hover["force"], 3)
        if "shape" in hover and (hover["shape"] > 0.0 or f"{curve}.shape" in vehicle.values):
            values[f"{curve}.shape"] = round(hover["shape"], 3)
        if f"{curve}.hover_voltage" in vehicle.values:  # else the autopilot compensates the battery
            values[f"{curve}.hover_voltage"] = round(hover["voltage"], 2)
    if "poses" in recording:
        values["mocap.latency"] = round(max(0.0, float(recording["poses"]["latency"][-1])), 4)
    if (loop := recorded_loop(recording)) is not None:
        values["vehicle.attitude_lag"] = round(loop.lag, 3)
        values["vehicle.attitude_dead_time"] = round(loop.dead_time, 3)
    if not values:
        raise RecordingError("measured neither the thrust in hover nor the attitude loop", file=path,
                             allowed="a flight by doorman fly, with attitude setpoints")  # fmt: skip
    return _write(file, values, as_json)


def _loaded(file: Path) -> VehicleFile:
    """The file at a path, which is never taken for the name of a shipped one."""
    from doorman.hardware.vehicle_file import VehicleFile
    from doorman.scenario.files import is_path

    return VehicleFile.load(str(file) if is_path(str(file)) else f"./{file}")


def _write(file: Path, values: Mapping[str, object], as_json: bool) -> int:
    from doorman.cli.terminal.display import print_result
    from doorman.hardware.vehicle_file import write_values
    from doorman.scenario.toml_text import value_text

    write_values(file, values)
    print_result(as_json, values, [f"{file}: {key} = {value_text(value)}" for key, value in values.items()])
    return 0
