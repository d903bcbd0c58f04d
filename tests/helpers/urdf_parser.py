"""An independent parser of URDFs, yourdfpy, which the package's own readers are compared with."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any


def load_description(path: Path) -> Any:
    """Links, joints and primitive shapes of a URDF as written, without meshes: yourdfpy's model, without a scene."""
    import yourdfpy  # takes half a second

    logging.getLogger("yourdfpy").setLevel(logging.ERROR)
    return yourdfpy.URDF.load(str(path), load_meshes=False, build_scene_graph=False)
