"""Tags on paper: where they go on leaf and frame, and a PDF with a page for each, true to size."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.door_sensor.config import CameraConfig, Mark
from doorman.door_sensor.detector import dictionary, opencv
from doorman.exceptions import BackendError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.quaternions import from_rotation, to_attitude
from doorman.model import Model

LEAF_TAG, FRAME_TAG = "2", "3"
_CLEAR = 0.12
"""Least distance of a tag's middle from the leaf's edges, over its own half [m]."""
_BESIDE = _CLEAR / 2
"""Distance of the frame tag's black square from the leaf's edge [m]."""


def usual_camera(field_of_view: float) -> CameraConfig:
    focal = 0.5 * CameraConfig().height / math.tan(0.5 * field_of_view)
    return CameraConfig(fx=focal, fy=focal)


def usual_marks(model: Model, size: float = 0.16, camera: CameraConfig | None = None) -> tuple[Mark, Mark]:
    """Tags for leaf and frame that the vehicle sees from its hover."""
    door, start = model.door, model.start_state
    body = model.coupling.vehicle_position(start[:3], float(start[3]), start[5:])
    lens = (camera or CameraConfig()).position[2]
    along, up = door.in_doorway(body - door.hinge_position)[1:]
    room = 0.5 * size * 1.25 + 0.01
    height = float(np.clip(up + lens, room, door.height - room))
    edge = min(_CLEAR + 0.5 * size, 0.5 * door.width)
    across = float(np.clip(along, edge, door.width - edge))
    before = door.surface_offset + door.way(model.start_angle)
    leaf = door.hinge_position + door.from_doorway(np.array([-door.surface_offset, across, height]))
    beside = door.hinge_position + door.from_doorway(
        np.array([-max(door.frame_depth, before if door.slides else 0.0), door.width + _BESIDE + 0.5 * size, height])
    )
    closed = door.link_placements(door.angle_of_opening(0.0))[door.section.leaf]
    return _mark(LEAF_TAG, closed, leaf, door, size), _mark(FRAME_TAG, door.placement, beside, door, size)


def _mark(name: str, link: Array, place: Array, door: Door, size: float) -> Mark:
    """A tag at a place in the world on the closed door's face, as its link has it."""
    out = -door.into
    right = np.cross(door.up, out)
    turn = link[:3, :3].T @ np.column_stack([right, door.up, out])
    x, y, z = (link[:3, :3].T @ (place - link[:3, 3])).tolist()
    return Mark(name, (x, y, z), to_attitude(from_rotation(turn)), size)


PAPERS = {"a4": (210.0, 297.0), "a3": (297.0, 420.0), "letter": (215.9, 279.4)}
"""Width and height by name [mm]."""
CELLS = 8
"""Cells along a tag's edge, with its black border."""
_POINT = 72.0 / 25.4
"""Points of a millimetre."""
_RULER = 100
"""Length of the line to check [mm]."""


class Page(NamedTuple):
    """One tag, and what is written under it."""

    mark: Mark
    lines: Sequence[str]


def tag_cells(number: int) -> NDArray[np.bool_]:
    """Which cells of a tag are black, rows from above, shape (8, 8)."""
    return np.asarray(opencv().aruco.generateImageMarker(dictionary(), number, CELLS, borderBits=1) == 0)


def tag_pdf(pages: Sequence[Page], paper: str = "a4") -> bytes:
    if paper not in PAPERS:
        raise BackendError("no such paper", field="--paper", given=paper, allowed=", ".join(PAPERS))
    width, height = PAPERS[paper]
    objects = [b"<< /Type /Catalog /Pages 2 0 R >>", b"", b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"]
    kids = []
    for page in pages:
        edge = 1e3 * page.mark.size
        if edge * (1.0 + 2.0 / CELLS) > width:
            raise BackendError("the tag is larger than the paper", field="size", given=page.mark.size,
                               allowed=f"up to {1e-3 * width / (1.0 + 2.0 / CELLS):.3f} m on {paper}")  # fmt: skip
        content = _content(page, edge, width, height).encode("latin-1", "replace")
        objects.append(b"<< /Length %d >>\nstream\n%s\nendstream" % (len(content), content))
        kids.append(f"{len(objects) + 1} 0 R")
        objects.append(
            f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {width * _POINT:.3f} {height * _POINT:.3f}] "
            f"/Resources << /Font << /F1 3 0 R >> >> /Contents {len(objects)} 0 R >>".encode()
        )
    objects[1] = f"<< /Type /Pages /Kids [{' '.join(kids)}] /Count {len(kids)} >>".encode()
    return _file(objects)


def _content(page: Page, edge: float, width: float, height: float) -> str:
    """Drawing of one page: origin below on the left, in millimetres."""
    cell, left, low = edge / CELLS, 0.5 * (width - edge), height - 25.0 - edge
    drawing = [f"{_POINT:.6f} 0 0 {_POINT:.6f} 0 0 cm", "0 g"]
    for row, column in zip(*np.nonzero(tag_cells(page.mark.tag)), strict=True):
        x, y = left + column * cell, low + (CELLS - 1 - row) * cell
        drawing.append(f"{x:.3f} {y:.3f} {cell:.3f} {cell:.3f} re f")
    middle = low + 0.5 * edge
    for x, y, along, up in (
        (0.5 * width, low - cell - 4.0, 0.2, 4.0), (0.5 * width, low + edge + cell, 0.2, 4.0),
        (left - cell - 4.0, middle, 4.0, 0.2), (left + edge + cell, middle, 4.0, 0.2),
    ):  # fmt: skip
        drawing.append(f"{x:.3f} {y:.3f} {along:.3f} {up:.3f} re f")
    top = low - cell - 14.0
    lines = [f"tag 36h11 no. {page.mark.tag}, black square {edge:.1f} mm; leave the white border", *page.lines]
    for k, line in enumerate(lines):
        text = line.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
        drawing.append(f"BT /F1 4.2 Tf 20 {top - 6.5 * k:.3f} Td ({text}) Tj ET")
    drawing.append(f"20 12 {_RULER:.3f} 0.4 re f 20 10 0.4 4 re f {20 + _RULER - 0.4:.3f} 10 0.4 4 re f")
    drawing.append("BT /F1 3.5 Tf 20 6 Td (this line is 100 mm long: print without scaling) Tj ET")
    return "\n".join(drawing)


def _file(objects: Sequence[bytes]) -> bytes:
    out, places = bytearray(b"%PDF-1.4\n"), []
    for number, content in enumerate(objects, 1):
        places.append(len(out))
        out += b"%d 0 obj\n%s\nendobj\n" % (number, content)
    table = len(out)
    out += b"xref\n0 %d\n0000000000 65535 f \n" % (len(objects) + 1)
    out += b"".join(b"%010d 00000 n \n" % place for place in places)
    out += b"trailer << /Size %d /Root 1 0 R >>\nstartxref\n%d\n%%%%EOF\n" % (len(objects) + 1, table)
    return bytes(out)
