"""What becomes of flights whose process hangs, dies, chatters or is let go."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from doorman.campaign.flights.flight_process import FlightProcess


@pytest.fixture
def flight_process(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    flight_process = FlightProcess("stubborn_program")
    yield flight_process
    flight_process.close()


def order(do: str, scenario: str = "any") -> dict:
    return {"do": do, "scenario": scenario}


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_a_pilot_flies_one_order_after_the_other_with_one_thread(flight_process):
    first, second = flight_process.fly(order("answer"), {}, 60.0), flight_process.fly(order("answer"), {}, 60.0)
    assert first["pid"] == second["pid"] and first["order"]["do"] == "answer"
    assert first["threads"] == "1"


def test_a_pilot_prepares_until_it_has_succeeded(flight_process):
    prepared = [
        flight_process.fly(order("answer", scenario), {}, 60.0)["prepared"] for scenario in ("unusable", "any", "any")
    ]
    assert prepared == [1, 2, 2]


def test_a_pilot_that_hangs_is_killed_and_the_next_order_gets_a_new_one(flight_process):
    pid = flight_process.fly(order("answer"), {}, 60.0)["pid"]
    answer = flight_process.fly(order("hang"), {}, 0.5)
    assert answer["error"] == "timed out after 0.5 s of wall-clock time" and answer["summary"] is None
    assert not alive(pid) and not answer.get("lost")
    assert flight_process.fly(order("answer"), {}, 60.0)["pid"] != pid


def test_a_pilot_that_dies_leaves_its_last_words(flight_process):
    answer = flight_process.fly(order("die"), {}, 60.0)
    assert "died with status -11" in answer["error"] and "told: die" in answer["error"] and answer["lost"]
    assert flight_process.fly(order("answer"), {}, 60.0)["order"]["do"] == "answer"


def test_a_pilot_that_was_let_go_is_gone(flight_process):
    pid = flight_process.fly(order("answer"), {}, 60.0)["pid"]
    flight_process.close()
    flight_process.close()
    assert not alive(pid)


def test_a_pilot_without_anybody_to_answer_ends():
    """The real one: nothing but the end of stdin tells it that its campaign was killed."""
    flight_process = FlightProcess()
    flight_process._start()
    process = flight_process._process
    process.stdin.write('{"prepare": true, "scenario": 3}\n')
    process.stdin.flush()
    assert "KeyError" in flight_process._answers.get(timeout=120)
    process.stdin.close()
    assert process.wait(60.0) == 0
    flight_process.close()
