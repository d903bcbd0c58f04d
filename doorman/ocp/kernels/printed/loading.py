"""Generated modules: written to the cache of compiled kernels under the hash of their text, and imported."""

from __future__ import annotations

import hashlib
import sys
import threading
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from doorman.compilation import PRINTED, cache_directory
from doorman.compilation.cache_files import write_atomically
from doorman.compilation.cache_place import fresh_directory

_LOADING = threading.RLock()
"""Held by the thread that runs a text: others wait for the whole module."""


def load(text: str) -> ModuleType:
    """Module of a text. What is run is the text that is given, never what a file says; numba only wants a file."""
    name = _name_of(text)
    with _LOADING:
        if name not in sys.modules:
            path = _written(f"{name}.py", text)
            module = ModuleType(name)
            module.__file__, module.TEXT = str(path), text  # type: ignore[attr-defined]
            exec(compile(text, str(path), "exec"), module.__dict__)
            sys.modules[name] = module  # last: no importer sees half of it
        return sys.modules[name]


@cache
def _name_of(text: str) -> str:
    return f"{PRINTED}{hashlib.sha256(text.encode()).hexdigest()[:16]}"


def remade(text: str, *numbers: Any) -> Any:
    """The model of a generated module with these numbers, also in another process."""
    return load(text).Model.of(*numbers)


def _written(name: str, text: str) -> Path:
    """A file of that text, in the cache, or in a temporary folder where that cannot be written."""
    try:
        path = cache_directory() / "problems" / name
        if not (path.is_file() and path.read_text(encoding="utf-8") == text):
            write_atomically(path, text.encode())
    except OSError:
        path = fresh_directory() / name
        path.write_text(text, encoding="utf-8")
    return path
