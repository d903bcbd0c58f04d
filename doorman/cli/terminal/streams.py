"""Standard streams as the system gives them: closed, of a poor encoding, or without a reader."""

from __future__ import annotations

import codecs
import os
import sys
from contextlib import suppress
from typing import IO

_PLAIN = {
    "°": " deg", "→": "->", "·": "*", "×": "x", "±": "+-", "−": "-", "–": "-", "…": "...", "≤": "<=", "≥": ">=", "²": "^2",
    "³": "^3", "µ": "u", "‘": "'", "’": "'", "“": '"', "”": '"',
    "α": "alpha", "β": "beta", "γ": "gamma", "η": "eta", "θ": "theta", "μ": "mu", "π": "pi", "τ": "tau", "φ": "phi",
    "ψ": "psi", "ω": "omega", "Ω": "Omega", "Φ": "Phi",
}  # fmt: skip
"""Words for signs that an encoding may not have; any other sign is a question mark."""
_HANDLER = "doorman.plain"


def steady_streams() -> None:
    """Make the standard streams safe to write to: any text, in any encoding, also where they are closed."""
    for expected in range(3):  # or the next file that is opened would get the number of a stream that is closed
        try:
            os.fstat(expected)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    sys.stdin = sys.stdin or open(os.devnull, encoding="utf-8")
    codecs.register_error(_HANDLER, _plain)
    for stream in (sys.stdout, sys.stderr):
        if stream is not None and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=_HANDLER)


def lost_stream() -> str:
    """Name of a standard stream that takes nothing any more; it is turned to nowhere. Empty if there is none."""
    lost = [name for name, stream in (("stdout", sys.stdout), ("stderr", sys.stderr)) if _is_lost(stream)]
    return " and ".join(lost)


def _is_lost(stream: IO[str] | None) -> bool:
    if stream is None:
        return False
    try:
        stream.flush()
    except OSError:
        with suppress(OSError, ValueError):  # the interpreter would try once more in the end, and complain
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
        return True
    return False


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_PLAIN.get(sign, "?") for sign in error.object[error.start : error.end]), error.end
