"""`doorman parameters`, `system`, `doctor` and `ros2`: their arguments and their help."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from doorman.cli.arguments import Settings, Source, Vehicle
from doorman.cli.command import VEHICLE, command
from doorman.cli.terminal.application import app


class Firmware(StrEnum):
    """Autopilots that parameters are written for."""

    PX4 = "px4"
    ARDUPILOT = "ardupilot"


class Reaction(StrEnum):
    """What a vehicle does when it does not hear us any more."""

    LAND = "land"
    RETURN = "return"


class SystemFileName(StrEnum):
    """Files for the vehicle's system."""

    UDEV = "udev"
    LIMITS = "limits"
    SERVICE = "service"


@command(app, VEHICLE)
def parameters(
    autopilot: Annotated[Firmware, typer.Argument(help="Firmware of the autopilot.")],
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    mocap: Annotated[
        bool | None,
        typer.Option(
            "--mocap/--no-mocap",
            help="Whether poses come from cameras.",
            show_default="the vehicle file's; yes without a file",
        ),
    ] = None,
    on_loss: Annotated[
        Reaction,
        typer.Option(help="What the autopilot does when this computer is silent: land in place, or on its pad."),
    ] = Reaction.LAND,
    mocap_delay: Annotated[
        float | None,
        typer.Option(
            metavar="SECONDS",
            help="Delay of poses from exposure to sending; for ArduPilot.",
            show_default="omitted",
        ),
    ] = None,
    telem: Annotated[int, typer.Option(min=0, max=3, help="Telemetry port that connects this computer; 0: USB.")] = 2,
    baud: Annotated[int, typer.Option(help="Baud rate of that port.")] = 921_600,
    flow_control: Annotated[
        bool, typer.Option("--flow-control/--no-flow-control", help="Whether RTS and CTS are also wired.")
    ] = False,
) -> int:
    """Print a parameter file for the autopilot of a scenario's vehicle: doorman parameters px4 > vehicle.params.

    A comment gives the reason of every line. The file contains the parameters that the checklist of doorman fly verifies,
    those of the telemetry port, and a first guess of the hover thrust. Load it with a ground station; for PX4 it has the
    format of QGroundControl.
    """
    from doorman.cli.setup.parameters import print_parameters
    from doorman.hardware.pixhawk.parameters.file import Port

    port = Port(telem, baud, flow_control)
    return print_parameters(autopilot.value, scenario, settings or [], mocap, on_loss.value, mocap_delay, vehicle, port)


@command(app, VEHICLE)
def system(file: Annotated[SystemFileName, typer.Argument(help="Which file.")]) -> int:
    """Print a file for the vehicle's Linux: udev rules for servo adapter and Pixhawk, limits, or a systemd unit.

    The first line of the file says where to put it: doorman system udev | sudo tee /etc/udev/rules.d/99-doorman.rules
    """
    from doorman.hardware.computer.doctor import SYSTEM_FILES

    typer.echo(SYSTEM_FILES[file.value].text, nl=False)
    return 0


@command(app, VEHICLE)
def doctor(
    folder: Annotated[
        Path, typer.Option("--runs", metavar="DIR", help="Folder of recordings.", show_default="runs")
    ] = Path("runs"),
    vehicle: Vehicle = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the rows as JSON.")] = False,
) -> int:
    """Check whether this computer is ready to fly, and print the command that fixes each problem.

    The command checks versions, permissions of serial devices, latency timers, ModemManager, real-time priority, governor,
    clock, network buffers, disk and compiled kernels. With --vehicle it also checks the devices of this file. It changes
    nothing. The exit status is 1 if a row is marked no.
    """
    from doorman.cli.setup.doctor import examine_computer

    return examine_computer(folder, as_json, vehicle)


@command(app, VEHICLE)
def ros2(
    scenario: Source = "paper",
    settings: Settings = None,
    vehicle: Vehicle = None,
    feed: Annotated[int, typer.Option(min=0, max=65535, help="UDP port on loopback for the flight's data.")] = 51100,
    domain: Annotated[int, typer.Option(min=0, max=232, envvar="ROS_DOMAIN_ID", help="Domain of the ROS graph.")] = 0,
    prefix: Annotated[str, typer.Option(metavar="NAME", help="Prefix of the published topics.")] = "doorman",
    poses: Annotated[
        str | None,
        typer.Option(
            metavar="TOPIC",
            help="PoseStamped topic of the vehicle; the node forwards its poses to --to.",
            show_default="none",
        ),
    ] = None,
    to: Annotated[int, typer.Option(min=1, max=65535, help="UDP port on loopback of the flight's --mocap.")] = 51001,
    object_name: Annotated[str, typer.Option(metavar="NAME", help="Name of the vehicle in that stream.")] = "vehicle",
    rate: Annotated[float, typer.Option(min=10.0, max=2000.0, metavar="HZ", help="Poses per second.")] = 100.0,
) -> int:
    """Connect a flight with ROS 2, without a ROS installation, until Ctrl-C.

    The node publishes odometry, joint states, the tip's force, plan, mission and markers of a flight with --feed, the URDFs, the
    transforms of vehicle, arm and door on /tf and /tf_static, and /clock in simulation. It receives poses for a flight whose
    --mocap is udp:51001. It uses DDS, the default of ROS 2. The flight does not depend on the node, and never waits for it.
    """
    from doorman.cli.setup.ros2 import PoseLink, run_bridge

    link = None if poses is None else PoseLink(poses, object_name, to, rate)
    return run_bridge(scenario, settings or [], feed, domain, prefix, link, vehicle)
