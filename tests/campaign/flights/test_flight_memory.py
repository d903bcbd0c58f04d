"""What a flight process gives back to the system."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from doorman.campaign.flights.flight_program import give_back_memory


def resident() -> int:
    """Memory of this process that no file backs [bytes]."""
    lines = Path("/proc/self/status").read_text(encoding="utf-8").splitlines()
    return 1024 * int(next(line for line in lines if line.startswith("RssAnon")).split()[1])


@pytest.mark.skipif(sys.platform != "linux", reason="glibc keeps what is free")
def test_free_memory_between_small_blocks_goes_back_to_the_system():
    before = resident()
    blocks = [bytes(5000) for _ in range(20_000)]
    kept = blocks[::100]  # among them, so that the heap does not shrink by itself
    del blocks
    fragmented = resident() - before
    give_back_memory()
    assert fragmented > 60e6, "this test is no test"
    assert resident() - before < 0.2 * fragmented, "the heap keeps what is free"
    assert len(kept) == 200
