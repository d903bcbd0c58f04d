"""`doorman vehicle door`: the door's frame as measured, written into a task."""

from __future__ import annotations

import math
from pathlib import Path

import typer

from doorman.cli.vehicles.ros2_door import door_source
from doorman.exceptions import BackendError
from doorman.flight.ground.door import mean_readings
from doorman.hardware.vehicle import VehicleLinks
from doorman.hardware.vehicle.waiting import await_links
from doorman.hardware.vehicle_file import VehicleFile, write_values
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.scenario.toml_text import value_text


def write_frame(file: Path, task: Path) -> int:
    """Measure, and write."""
    vehicle = VehicleFile.load(str(file.resolve()))
    model = Model(vehicle.scenario(str(task.resolve())))
    config = vehicle.links(model)
    with VehicleLinks(config, door=door_source(config)) as links:
        await_links(links)
        leaf, frame = mean_readings(links, 2.0)
    if frame is None:
        said = "; ".join(words for _, words in links.door.events()) if links.door is not None else ""
        raise BackendError(
            f"the frame was not seen: {said or 'no reading'}", field="door_sensor.frame", allowed="a mark in sight"
        )
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
