"""`doorman tags print` and `doorman vehicle door`: what is stuck on a door, and where that stands."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from doorman.cli.command import VEHICLE, app, command
from doorman.cli.options import Settings, Source, valued
from doorman.cli.vehicles.vehicle_file import group as vehicle
from doorman.exceptions import BackendError

if TYPE_CHECKING:  # commands import what they run when they run it
    from doorman.hardware.door import DoorSource, Mark
    from doorman.hardware.vehicle import VehicleConfig
    from doorman.model import Model

_ROS2 = "ros2:"
tags = typer.Typer(help="Tags to stick on a door: measure the leaf by a camera on the vehicle.", no_args_is_help=True)
app.add_typer(tags, name="tags", rich_help_panel=VEHICLE)


@command(name="print", group=tags)
def print_(
    scenario: Source = "push",
    settings: Settings = None,
    size: Annotated[float, typer.Option(min=0.02, help="Edge of the black square [m].")] = 0.16,
    paper: Annotated[str, typer.Option(help="a4, a3 or letter.")] = "a4",
    out: Annotated[Path, valued("FILE", "PDF to write.")] = Path("tags.pdf"),
) -> int:
    """Write a PDF with a tag for the leaf and one for the frame, true to size, and print the table for the vehicle file.

    Each page says where its tag goes. Print without scaling: a line on the page is 100 mm long.
    """
    from doorman.cli.task import load_task
    from doorman.door_sensor.printing import Page, tag_pdf, usual_marks
    from doorman.model import Model
    from doorman.scenario.toml_text import value_text

    def rounded(values: Sequence[float]) -> str:
        return value_text([round(value, 4) + 0.0 for value in values])

    model = Model(load_task(scenario, settings, None))
    leaf, frame = usual_marks(model, size)
    out.write_bytes(tag_pdf([Page(leaf, _place(model, leaf, on_leaf=True)), Page(frame, _place(model, frame))], paper))
    typer.echo(f"{out}: two pages. For the vehicle file:\n")
    typer.echo('[door_sensor]\nsource = "tags"')
    for name, mark in (("leaf", leaf), ("frame", frame)):
        numbers = f"position = {rounded(mark.position)}, attitude = {rounded(mark.attitude)}, size = {size:g}"
        typer.echo(f'{name} = {{ name = "{mark.name}", {numbers} }}')
    return 0


def _place(model: Model, mark: Mark, on_leaf: bool = False) -> list[str]:
    """Where a tag's middle goes, in words."""
    import numpy as np

    door = model.door
    link = door.link_placements(door.angle_of_opening(0.0))[door.section.leaf] if on_leaf else door.placement
    place = (link @ [*mark.position, 1.0])[:3]
    _, along, up = door.in_doorway(np.asarray(place) - door.hinge_position).tolist()
    edge = "from the leaf's left or hinge-side edge" if door.slides else "from the hinge line towards the latch"
    return [
        "on the face of the leaf that the vehicle sees"
        if on_leaf
        else "on the frame or the wall beside it, towards the vehicle",
        f"middle {100 * along:.1f} cm {edge}, {100 * up:.1f} cm above the leaf's lower edge",
        "upright, flat, and not to be moved afterwards; if it sits elsewhere, write its place into the vehicle file",
    ]


@command(group=vehicle)
def door(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="The vehicle file, with [door_sensor].")],
    task: Annotated[Path, typer.Argument(metavar="TASK", help="The task's TOML file; the command keeps its comments.")],
) -> int:
    """Measure the door's frame with the vehicle's sensor, and write where it stands into the task.

    The vehicle stands on its pad, disarmed. The command opens all links and sends no setpoints.
    """
    from doorman.flight.ground.door import mean_readings
    from doorman.hardware.vehicle import VehicleLinks
    from doorman.hardware.vehicle.waiting import await_links
    from doorman.hardware.vehicle_file import VehicleFile, write_values
    from doorman.model import Model
    from doorman.scenario import Scenario
    from doorman.scenario.toml_text import value_text

    flown = VehicleFile.load(str(file.resolve()))
    model = Model(flown.scenario(str(task.resolve())))
    config = flown.links(model)
    with VehicleLinks(config, door=door_source(config)) as links:
        await_links(links)
        leaf, frame = mean_readings(links, 2.0)
    if frame is None:
        said = "; ".join(words for _, words in links.door.events()) if links.door is not None else ""
        words = f"the frame was not seen: {said or 'no reading'}"
        raise BackendError(words, field="door_sensor.frame", allowed="a mark in sight")
    values: dict[str, object] = {
        "door.position": [round(value, 4) + 0.0 for value in frame.position.tolist()],
        "door.yaw": round(frame.yaw, 5) + 0.0,
    }
    write_values(task, values, Scenario)
    for key, value in values.items():
        typer.echo(f"{task}: {key} = {value_text(value)}")
    if leaf is not None:
        angle = model.door.angle_of_joint(leaf.joint)
        typer.echo(f"The leaf stands at {model.door.in_words(angle)}, joint value {leaf.joint:.3f} {model.door.unit}"
                   f" ± {math.ceil(1e4 * leaf.deviation) / 1e4:g}.")  # fmt: skip
    return 0


def door_source(config: VehicleConfig) -> DoorSource | None:
    """The sensor of the door that is a topic of ROS 2, which only this layer may know; None where the links make their own."""
    sensor = config.door_sensor
    if sensor is None or not sensor.source.startswith(_ROS2):
        return None
    from doorman.ros2.door_source import JointStateSource

    return JointStateSource(sensor.source.removeprefix(_ROS2), sensor.joint)
