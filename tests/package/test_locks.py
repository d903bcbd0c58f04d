"""Locks between processes: held by one, free when it dies, and never through a link."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from doorman.locks import locked

HOLD = """
import sys, time
from pathlib import Path
from doorman.locks import locked
with locked(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60)
"""


def holder(path: Path) -> subprocess.Popen[str]:
    process = subprocess.Popen([sys.executable, "-c", HOLD, str(path)], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "held\n"
    return process


def test_one_process_at_a_time_and_a_dead_one_holds_nothing(tmp_path):
    path = tmp_path / ".lock"
    process = holder(path)
    with pytest.raises(BlockingIOError), locked(path):
        pass
    process.send_signal(signal.SIGKILL)
    process.communicate(timeout=30)
    assert path.exists()  # left behind, and free all the same
    with locked(path):
        assert path.exists()
    assert not path.exists()


def test_links_are_not_followed(tmp_path):
    mine = tmp_path / "mine.txt"
    mine.write_text("precious")
    for target in (mine, tmp_path / "nowhere"):
        link = tmp_path / f"{target.name}.lock"
        link.symlink_to(target)
        with pytest.raises(OSError, match=r".*"), locked(link):
            pass
        assert link.is_symlink()
    assert mine.read_text() == "precious" and not (tmp_path / "nowhere").exists()
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="plain file"), locked(tmp_path / "pipe"):
        pass


def test_whoever_waits_gets_it_once_at_a_time(tmp_path):
    path, inside, most = tmp_path / ".lock", [], []

    def work() -> None:
        for _ in range(30):
            with locked(path, wait=True):
                inside.append(1)
                most.append(len(inside))
                inside.pop()

    threads = [threading.Thread(target=work) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(most) == 180 and max(most) == 1 and not path.exists()
