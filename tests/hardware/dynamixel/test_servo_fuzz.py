"""A seeded sample of the fuzz in fuzz_servo_answers.py, and proof that it would notice."""

from __future__ import annotations

import pytest
from fuzz_servo_answers import fuzz

from doorman.hardware.dynamixel.link import Link
from doorman.hardware.dynamixel.monitor import ServoClock


def test_hostile_answers():
    counts = fuzz(2000, seed=20200531)
    assert counts["fresh"] > 500
    assert counts["held"] > 500


def test_an_adapter_that_trusts_every_answer_would_be_noticed(monkeypatch):
    monkeypatch.setattr(ServoClock, "lateness", lambda *arguments: 0.0)
    with pytest.raises(AssertionError, match="s old"):
        fuzz(2000, seed=1)


def test_an_adapter_that_keeps_old_bytes_would_be_noticed(monkeypatch):
    monkeypatch.setattr(Link, "_settle", lambda link: None)
    with pytest.raises(AssertionError, match="believed what nobody said"):
        fuzz(2000, seed=1)
