"""The page that shows a flight in three dimensions: meshcat's viewer, this folder's script, and the drawing, in one file.

The page needs neither network nor meshcat's server: the viewer's script stands in it, and what the server would send is data.
"""

from __future__ import annotations

import html
import importlib.util
import json
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import Any

from doorman.exceptions import DoormanError, how_to_install
from doorman.visualization.scene.meshcat_scene import Command


def page(title: str, scene: Command, frames: Sequence[dict[str, Any]], live: str = "") -> str:
    folder = Path(__file__).parent
    template = Template((folder / "view.html").read_text(encoding="utf-8"))
    data = {"scene": scene, "frames": list(frames), "live": live}
    return template.substitute(
        title=html.escape(title),
        viewer=_viewer_source(),
        flight=_in_script(json.dumps(data, allow_nan=False, separators=(",", ":"))),
        script=(folder / "view.js").read_text(encoding="utf-8"),
    )


def _in_script(data: str) -> str:
    """JSON that neither ends the script element that it stands in, nor opens another."""
    return data.replace("<", "\\u003c")


def _viewer_source() -> str:
    """The viewer as one script; the package is not imported, for it would bring its server along."""
    package = importlib.util.find_spec("meshcat")
    for folder in (package.submodule_search_locations or []) if package is not None else []:
        file = Path(folder) / "viewer" / "dist" / "main.min.js"
        if file.is_file():
            return file.read_text(encoding="utf-8")
    raise DoormanError("the page needs meshcat", field="meshcat", allowed=how_to_install("viz"))
