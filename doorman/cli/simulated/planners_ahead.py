"""A second process of a warm-up: it compiles planners, while the first one compiles the rest."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import doorman


@contextmanager
def planners_ahead(
    sources: Sequence[str], settings: Sequence[str], vehicle: str | None
) -> Iterator[subprocess.Popen[bytes]]:
    """Have another process compile the planners of some scenarios into the cache; it ends with the block at the latest."""
    # What it cannot do, the first process will: whatever goes wrong there is told by the first one.
    task = json.dumps({"sources": list(sources), "settings": list(settings), "vehicle": vehicle})
    places = [str(Path(doorman.__file__).parents[1]), *filter(None, [os.environ.get("PYTHONPATH")])]
    process = subprocess.Popen(
        [sys.executable, "-m", __name__, task], env={**os.environ, "PYTHONPATH": os.pathsep.join(places), "PYTHONSAFEPATH": "1"},
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.kill()  # what it has compiled by now is in the cache, and files there are whole or not at all
        process.wait()


def main() -> None:
    from doorman.cli.task import load_task
    from doorman.planning.planner import Planner

    task = json.loads(sys.argv[1])
    for source in task["sources"]:
        Planner(load_task(source, task["settings"], task["vehicle"]))


if __name__ == "__main__":
    main()
