"""A seeded sample of the fuzz in fuzz_mocap_packets.py, and proof that it would notice."""

from __future__ import annotations

import pytest
from fuzz_mocap_packets import fuzz

from doorman.hardware.mocap.sequence import FrameClock, FrameSequence, Order
from doorman.hardware.mocap.stream import StreamReader


def test_hostile_datagrams():
    counts = fuzz(1500, seed=20200531)
    assert counts["MEASURED"] > 1000
    assert counts["PREDICTED"] > 100
    assert counts["LOST"] > 100


CLASSIFY = FrameSequence.classify


def takes_late_ones(sequence, number, arrival):
    order = CLASSIFY(sequence, number, arrival)
    return Order.SAME if order is Order.LATE else order


@pytest.mark.parametrize(
    ("part", "name", "careless", "told"),
    [
        (FrameClock, "time_of", lambda clock, frame, arrival: arrival - 0.005, "too new"),
        (StreamReader, "_unseen", lambda reader, found: True, "too new"),
        (StreamReader, "_welcome", lambda reader, sender: True, "believed what nobody said"),
        (FrameSequence, "classify", takes_late_ones, "too new"),
    ],
)
def test_a_careless_adapter_would_be_noticed(monkeypatch, part, name, careless, told):
    monkeypatch.setattr(part, name, careless)
    with pytest.raises(AssertionError, match=told):
        fuzz(4000, seed=1)
