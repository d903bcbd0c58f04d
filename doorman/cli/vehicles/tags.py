"""`doorman tags print`: a PDF of tags, and the table that the vehicle file needs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import typer

from doorman.cli.overrides import parse_overrides
from doorman.door_sensor.printing import Page, tag_pdf, usual_marks
from doorman.hardware.door import Mark
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.scenario.toml_text import value_text


def write_tags(source: str, settings: list[str], size: float, paper: str, out: Path) -> int:
    """The PDF, and what the vehicle file needs."""
    model = Model(Scenario.load(source, parse_overrides(settings)))
    leaf, frame = usual_marks(model, size)
    pages = [Page(leaf, where(model, leaf, on_leaf=True)), Page(frame, where(model, frame, on_leaf=False))]
    out.write_bytes(tag_pdf(pages, paper))
    typer.echo(f"{out}: two pages. For the vehicle file:\n")
    typer.echo('[door_sensor]\nsource = "tags"')
    for name, mark in (("leaf", leaf), ("frame", frame)):
        numbers = [[round(value, 4) + 0.0 for value in values] for values in (mark.position, mark.attitude)]
        words = f"position = {value_text(numbers[0])}, attitude = {value_text(numbers[1])}, size = {size:g}"
        typer.echo(f'{name} = {{ name = "{mark.name}", {words} }}')
    return 0


def where(model: Model, mark: Mark, on_leaf: bool) -> list[str]:
    """Where a tag's middle goes, in words."""
    door = model.door
    link = door.link_placements(door.angle_of_opening(0.0))[door.section.leaf] if on_leaf else door.placement
    place = (link @ [*mark.position, 1.0])[:3]
    _, along, up = door.in_doorway(np.asarray(place) - door.hinge_position).tolist()
    side = (
        "on the face of the leaf that the vehicle sees"
        if on_leaf
        else "on the frame or the wall beside it, towards the vehicle"
    )
    edge = "from the hinge line towards the latch" if not door.slides else "from the leaf's left or hinge-side edge"
    return [
        side,
        f"middle {100 * along:.1f} cm {edge}, {100 * up:.1f} cm above the leaf's lower edge",
        "upright, flat, and not to be moved afterwards; if it sits elsewhere, write its place into the vehicle file",
    ]
