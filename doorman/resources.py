"""Files that ship with doorman: URDFs, scenarios and vehicle files, found in a checkout and in an installed wheel alike."""

from __future__ import annotations

import os
from pathlib import Path

_PACKAGE = Path(__file__).parent


def urdf_directory() -> Path:
    """Directory of the shipped URDFs: inside the package in a wheel, beside it in a checkout."""
    packaged = _PACKAGE / "urdf"
    return packaged if packaged.is_dir() else _PACKAGE.parent / "urdf"


def scenario_directory() -> Path:
    """Directory of the shipped scenarios."""
    return _PACKAGE / "scenarios"


def vehicle_directory() -> Path:
    """Directory of the shipped vehicle files."""
    return _PACKAGE / "vehicles"


def shipped(directory: Path, suffix: str) -> dict[str, Path]:
    """Paths of the shipped files of one kind, by name without suffix."""
    return {path.stem: path for path in sorted(directory.glob(f"*{suffix}"))}


def own_process() -> dict[str, str]:
    """Environment of a process that imports this package, and no file of the user's folder in the place of a module."""
    paths = os.pathsep.join(filter(None, (str(_PACKAGE.parent), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": paths, "PYTHONSAFEPATH": "1"}
