"""A file that one recorder alone writes."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import IO

from doorman.locks import lock_stream


def claimed_stream(path: Path) -> IO[bytes]:
    """The file, emptied, for one recorder alone."""
    stream = open(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, 0o666), "wb")
    try:
        if is_regular(stream):
            lock_stream(stream.fileno())
            stream.truncate(0)
    except BaseException:
        stream.close()
        raise
    return stream


def is_regular(stream: IO[bytes]) -> bool:
    """Whether it is a file, and neither a pipe nor a device."""
    return stat.S_ISREG(os.fstat(stream.fileno()).st_mode)
