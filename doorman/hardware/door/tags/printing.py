"""Tags on paper: a PDF with a page for each, true to size, that says where to stick it.

The PDF holds rectangles and text only, so it needs no other program, and a printer that does not scale it prints squares of the
right size. A line of 100 mm on every page shows whether it did.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from doorman.exceptions import BackendError
from doorman.hardware.door.config import Mark
from doorman.hardware.door.tags.detector import dictionary, opencv

PAPERS = {"a4": (210.0, 297.0), "a3": (297.0, 420.0), "letter": (215.9, 279.4)}
"""Width and height by name [mm]."""
CELLS = 8
"""Cells along a tag's edge, with its black border."""
_POINT = 72.0 / 25.4
"""Points of a millimetre."""
_RULER = 100.0
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
