"""`doorman vehicle`: the commands that write a vehicle file, their arguments and their help."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.arguments import Settings, Source
from doorman.cli.terminal import panels
from doorman.cli.vehicles.door_commands import door_command

_File = Annotated[Path, typer.Argument(metavar="FILE", help="The vehicle file; the command keeps its comments.")]
_Json = Annotated[bool, typer.Option("--json", help="Print the written values as JSON.")]


def add_vehicle_file_commands(app: typer.Typer, leave: Callable[[Callable[[], int]], None]) -> None:
    group = typer.Typer(
        help="Write a vehicle file and add calibrations to it: URDF, links, servos, cameras, thrust.",
        no_args_is_help=True,
    )
    group.command("new")(_new_command(leave))
    group.command("zeros")(_zeros_command(leave))
    group.command("object")(_object_command(leave))
    group.command("origin")(_origin_command(leave))
    group.command("door")(door_command(leave))
    group.command("learn")(_learn_command(leave))
    app.add_typer(group, name="vehicle", rich_help_panel=panels.VEHICLE)


def _new_command(leave: Callable[[Callable[[], int]], None]) -> Callable[..., None]:
    def new(
        file: Annotated[Path, typer.Argument(metavar="FILE", help="New file to write.")],
        urdf: Annotated[
            str, typer.Option(metavar="URDF", help="URDF of the vehicle: a path, or the name of a shipped one.")
        ] = "hexarotor_arm",
        base_link: Annotated[str, typer.Option(metavar="LINK", help="Base link of the multirotor.")] = "base_link",
        tip: Annotated[str, typer.Option(metavar="FRAME", help="Frame of the arm's tip.")] = "tip",
        every_key: Annotated[
            bool, typer.Option("--all", help="Also write all other keys and their defaults, as comments.")
        ] = False,
    ) -> None:
        """Write a vehicle file with comments, for you to fill in.

        Its servos are those of the URDF's arm, then a gripper's.
        """

        def command() -> int:
            from doorman.cli.vehicles.vehicle_file import new_file

            return new_file(file, urdf, base_link, tip, every_key)

        leave(command)

    return new


def _zeros_command(leave: Callable[[Callable[[], int]], None]) -> Callable[..., None]:
    def zeros(
        file: _File,
        posture: Annotated[
            str,
            typer.Option(metavar="ANGLES", help="Angles of all joints, then of the gripper, as in the URDF [rad]."),
        ],
        servos: Annotated[
            str | None, typer.Option(metavar="DEVICE", help="Serial device of the servos.", show_default="the file's")
        ] = None,
        as_json: _Json = False,
    ) -> None:
        """Read the servos' positions and write the zeros of their joints.

        Hold the arm in a known posture, with torque off as after power-on. The directions in the file must already be right.
        """

        def command() -> int:
            from doorman.cli.vehicles.vehicle_file import write_zeros

            return write_zeros(file, posture, servos, as_json)

        leave(command)

    return zeros


def _object_command(leave: Callable[[Callable[[], int]], None]) -> Callable[..., None]:
    def object_(
        file: _File,
        at: Annotated[str, typer.Option(metavar="X,Y,Z", help="Position of O_B in the world [m], by plumb line.")],
        yaw: Annotated[float, typer.Option(metavar="ANGLE", help="Heading of the vehicle [rad].")] = 0.0,
        mocap: Annotated[
            str | None, typer.Option(metavar="LINK", help="Link to the cameras.", show_default="the file's")
        ] = None,
        as_json: _Json = False,
    ) -> None:
        """Measure the tracked object with the cameras, and write its pose in the body.

        Put the vehicle down level at a known position. Write the cameras' axes first: doorman vehicle origin.
        """

        def command() -> int:
            from doorman.cli.vehicles.vehicle_file import write_object

            return write_object(file, at, yaw, mocap, as_json)

        leave(command)

    return object_


def _origin_command(leave: Callable[[Callable[[], int]], None]) -> Callable[..., None]:
    def origin(
        file: _File,
        hinge: Annotated[str, typer.Option(metavar="X,Y,Z", help="Lower end of the hinge line [m].")],
        latch: Annotated[str, typer.Option(metavar="X,Y,Z", help="Lower end of the closed leaf's free edge [m].")],
        scenario: Source = "paper",
        settings: Settings = None,
        as_json: _Json = False,
    ) -> None:
        """Write the pose of the cameras' axes in the world, from two points of the closed door, measured in these axes.

        The door is that of the scenario. Its URDF defines the world.
        """

        def command() -> int:
            from doorman.cli.vehicles.vehicle_file import write_origin

            return write_origin(file, hinge, latch, scenario, settings or [], as_json)

        leave(command)

    return origin


def _learn_command(leave: Callable[[Callable[[], int]], None]) -> Callable[..., None]:
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
        as_json: _Json = False,
    ) -> None:
        """Write measurements of a flight: thrust in hover, latency of the poses, lag of the attitude."""

        def command() -> int:
            from doorman.cli.vehicles.vehicle_file import write_learned

            return write_learned(file, run, as_json)

        leave(command)

    return learn
