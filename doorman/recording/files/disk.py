"""A recording's file on its disk: claimed by one recorder alone, and synced without holding up its writer."""

from __future__ import annotations

import contextlib
import os
import stat
import threading
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


class Syncer:
    """A thread that calls fsync on request; requests that come meanwhile are met by one call afterwards."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = os.dup(descriptor)
        self._requested = threading.Event()
        self._over = False
        self._error: OSError | None = None
        self._thread = threading.Thread(target=self._run, name="recording's syncer", daemon=True)
        self._thread.start()

    def request(self) -> None:
        if self._error is not None:
            raise self._error
        self._requested.set()

    def sync(self) -> None:
        if self._error is not None:
            raise self._error
        os.fsync(self._descriptor)

    def stop(self) -> None:
        """End the thread; may be called twice."""
        self._over = True
        self._requested.set()
        if threading.current_thread() is not self._thread:  # garbage may be collected on any
            self._thread.join()

    def _run(self) -> None:
        try:
            while True:
                self._requested.wait()
                self._requested.clear()
                if self._over:
                    return
                os.fsync(self._descriptor)
        except OSError as error:
            self._error = error
        finally:
            os.close(self._descriptor)


def sync_folder(folder: Path) -> None:
    """Write the names of new files in a folder to the disk, where its file system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
