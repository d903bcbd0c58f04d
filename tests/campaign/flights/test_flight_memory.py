"""What a flight process gives back to the system."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

PROCESS = """
import json
from pathlib import Path
from doorman.campaign.flights.flight_program import give_back_memory

def resident():
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return 1024 * int(next(line for line in lines if line.startswith("RssAnon")).split()[1])

before = resident()
blocks = [bytes(5000) for _ in range(20_000)]
kept = blocks[::100]  # among them, so that the heap does not shrink by itself
del blocks
fragmented = resident() - before
give_back_memory()
print(json.dumps([fragmented, resident() - before, len(kept)]))
"""
"""A process of its own: in a long one, the blocks find room in what others have left."""


@pytest.mark.skipif(sys.platform != "linux", reason="glibc keeps what is free")
def test_free_memory_between_small_blocks_goes_back_to_the_system() -> None:
    done = subprocess.run([sys.executable, "-c", PROCESS], capture_output=True, text=True, timeout=120, check=True)
    fragmented, left, kept = json.loads(done.stdout)
    assert fragmented > 60e6, "this test is no test"
    assert left < 0.2 * fragmented, "the heap keeps what is free"
    assert kept == 200
