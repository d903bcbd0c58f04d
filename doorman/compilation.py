"""Ahead-of-flight compilation: the decorator of every numba kernel, and its cache on disk.

numba does not notice when a kernel that another kernel calls has changed in a different file, so the cache directory is
named by a hash over the sources of all kernels and over the versions of numba and Python: a change anywhere starts afresh.
"""

from __future__ import annotations

import hashlib
import os
import platform
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_PACKAGE = Path(__file__).parent
_FAST_MATH = {"contract", "reassoc", "nsz", "arcp"}  # no assumption that NaN or inf cannot occur: they must show


@cache
def cache_directory() -> Path:
    """Directory of compiled kernels: under NUMBA_CACHE_DIR if set, else under the user's cache directory.

    Returns:
        An existing, writable directory; a temporary one where the user's cache directory cannot be written.
    """
    digest = hashlib.sha256(f"{numba.__version__} {sys.version} {platform.machine()}".encode())
    for source in sorted(_PACKAGE.rglob("*.py")):
        text = source.read_bytes()
        if b"@kernel" in text:
            digest.update(text)
    base = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    name = f"doorman-{digest.hexdigest()[:16]}"
    for candidate in (Path(base) / name, Path(tempfile.gettempdir()) / name):
        try:
            candidate.mkdir(parents=True, exist_ok=True)
            if os.access(candidate, os.W_OK):
                return candidate
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="doorman-"))


def kernel(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function of arrays and scalars with numba: cached on disk, without the GIL, IEEE errors as NaN and inf.

    Args:
        function: Plain Python function that imports every kernel it calls (a kernel passed as an argument is never cached).

    Returns:
        The dispatcher; its `py_func` is the plain function.
    """
    settings: Any = numba.config
    previous = settings.CACHE_DIR
    settings.CACHE_DIR = str(cache_directory())
    try:
        dispatcher: Callable[Parameters, Result] = numba.njit(
            cache=True, nogil=True, error_model="numpy", fastmath=_FAST_MATH
        )(function)
        return dispatcher
    finally:
        settings.CACHE_DIR = previous
