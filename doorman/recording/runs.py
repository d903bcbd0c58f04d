"""Where recordings are: the file in a run's folder, and the newest one."""

from __future__ import annotations

from pathlib import Path

from doorman.exceptions import RecordingError

RUNS = Path("runs")
"""Folder, below the current one, in which commands put their files by default."""

_FILE = "recording.mcap"
_SUFFIX = ".mcap"


def recording_file(run: Path) -> Path:
    """The recording of a run: the file itself, or the one in the run's folder."""
    if run.is_file():
        return run
    if not run.is_dir():
        raise RecordingError("no such run", given=str(run), allowed="a run's folder, or an MCAP file")
    if (run / _FILE).is_file():
        return run / _FILE
    found = sorted(run.glob(f"*{_SUFFIX}"))
    if len(found) != 1:
        names = ", ".join(file.name for file in found) or "no MCAP file"
        raise RecordingError("not the folder of one run", file=run, given=names, allowed=f"{_FILE}, or one MCAP file")
    return found[0]


def newest_recording(folder: Path = RUNS) -> Path:
    """The recording that was written last, in a folder or in the folders of runs in it."""
    found = [(_written(file), file) for file in (*folder.glob(f"*{_SUFFIX}"), *folder.glob(f"*/*{_SUFFIX}"))]
    times = [(time, file) for time, file in found if time is not None]
    if not times:
        allowed = "a run's folder, an MCAP file, or a run that doorman open left there"
        raise RecordingError("no run there yet", file=folder, allowed=allowed)
    return max(times)[1]


def _written(file: Path) -> int | None:
    try:
        return file.stat().st_mtime_ns if file.is_file() else None
    except OSError:
        return None
