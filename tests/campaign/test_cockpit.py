"""What becomes of flights whose process hangs, dies, chatters or is let go."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from doorman.campaign.cockpit import Cockpit


@pytest.fixture
def cockpit(monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    cockpit = Cockpit("stubborn_pilot")
    yield cockpit
    cockpit.close()


def order(do: str, scenario: str = "any") -> dict:
    return {"do": do, "scenario": scenario}


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def test_a_pilot_flies_one_order_after_the_other_with_one_thread(cockpit):
    first, second = cockpit.fly(order("answer"), {}, 60.0), cockpit.fly(order("answer"), {}, 60.0)
    assert first["pid"] == second["pid"] and first["order"]["do"] == "answer"
    assert first["threads"] == "1"


def test_a_pilot_prepares_until_it_has_succeeded(cockpit):
    prepared = [cockpit.fly(order("answer", scenario), {}, 60.0)["prepared"] for scenario in ("unusable", "any", "any")]
    assert prepared == [1, 2, 2]


def test_a_pilot_that_hangs_is_killed_and_the_next_order_gets_a_new_one(cockpit):
    pid = cockpit.fly(order("answer"), {}, 60.0)["pid"]
    answer = cockpit.fly(order("hang"), {}, 0.5)
    assert answer["error"] == "timed out after 0.5 s of wall-clock time" and answer["summary"] is None
    assert not alive(pid) and not answer.get("lost")
    assert cockpit.fly(order("answer"), {}, 60.0)["pid"] != pid


def test_a_pilot_that_dies_leaves_its_last_words(cockpit):
    answer = cockpit.fly(order("die"), {}, 60.0)
    assert "died with status -11" in answer["error"] and "told: die" in answer["error"] and answer["lost"]
    assert cockpit.fly(order("answer"), {}, 60.0)["order"]["do"] == "answer"


def test_a_pilot_that_was_let_go_is_gone(cockpit):
    pid = cockpit.fly(order("answer"), {}, 60.0)["pid"]
    cockpit.close()
    cockpit.close()
    assert not alive(pid)


def test_a_pilot_without_anybody_to_answer_ends(task):
    """The real one: nothing but the end of stdin tells it that its campaign was killed."""
    from doorman.campaign import Campaign

    cockpit = Cockpit()
    cockpit._start()
    process = cockpit._process
    flight = Campaign(str(task)).flights(1)[0]
    process.stdin.write('{"prepare": true, "scenario": 3}\n')
    process.stdin.flush()
    assert "KeyError" in cockpit._answers.get(timeout=120)
    assert flight.draw.run == 0
    process.stdin.close()
    deadline = time.monotonic() + 60.0
    while process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
    assert process.poll() == 0
    process.stdout.close()
    cockpit._printed.close()
    cockpit._process = None
    cockpit.close()
