"""What decides about the last bit of a flight besides its scenario: doorman's code, and the packages that compute."""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
from functools import cache
from pathlib import Path

import doorman

_ENGINES = ("numpy", "numba", "mujoco", "pin", "coal", "proxsuite")


@cache
def software() -> dict[str, str]:
    """Versions by name, `doorman` with a digest of its sources among them."""
    package = Path(doorman.__file__).parent
    sources = sorted(package.rglob("*.py"))
    code = hashlib.sha256(b"".join(path.read_bytes() for path in sources if "visualization" not in path.parts))
    return {
        "doorman": f"{doorman.__version__} {code.hexdigest()[:16]}",
        **{name: importlib.metadata.version(name) for name in _ENGINES},
        "python": platform.python_version(),
        "machine": platform.machine(),
    }


def differences(theirs: dict[str, str]) -> str:
    """Where another process's software differs from this one's, in words; empty where it does not."""
    mine = software()
    names = [name for name in {**mine, **theirs} if mine.get(name) != theirs.get(name)]
    return ", ".join(f"{name} {mine.get(name, 'missing')} instead of {theirs.get(name, 'none')}" for name in names)
