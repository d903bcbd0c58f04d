"""Whether a failure states its true reason, and what the report says of it."""

from __future__ import annotations

import json

import pytest

from doorman.campaign.judgement import told_truly
from doorman.campaign.report.figures import figures
from doorman.campaign.report.pages import page
from doorman.scenario import Scenario
from doorman.simulation.reality.causes import ELSEWHERE, LATCHED, LATE, NEVER_CLOSED, NOISY, SEALED, SLIPPED, WIND


@pytest.mark.parametrize(
    ("reason", "causes", "truly"),
    [
        ("the gripper does not hold the leaf", [SLIPPED], True),
        ("the gripper does not hold the leaf", [NEVER_CLOSED, WIND], True),
        ("the gripper does not hold the leaf", [WIND], False),
        ("the door does not move on from 90.0° against 5.00 N m", [LATCHED], True),
        ("the door does not give way: the vehicle is 3° ahead of it at 89.0°", [SEALED], True),
        ("contact was lost 20 times", [LATCHED], False),
        ("the door does not move on from 60.0° against 3.10 N m", [SLIPPED], False),
        ("the wind is too strong", [WIND], True),
        ("the vehicle did not come to hover still within 15 s, and felt wind of up to 4.0 N", [WIND], True),
        ("the vehicle did not come to hover still within 15 s, and felt wind of up to 4.0 N", [LATE], False),
        ("the poses are too old for contact: 72 ms; allowed: 63 ms", [LATE], True),
        ("the poses are too noisy for contact: 2.0 mm make 0.50 N at the tip; allowed: 0.33 N", [NOISY], True),
        ("contact was lost 20 times", [WIND, ELSEWHERE], None),
        ("", [], None),
    ],
)
def test_a_reason_is_compared_with_the_truth(reason, causes, truly):
    assert told_truly({"reason": reason, "true_causes": causes}) is truly


def test_a_summary_without_causes_compares_nothing():
    assert told_truly({"reason": "contact was lost 3 times"}) is None


def test_the_report_counts_and_names_wrong_reasons():
    common = {
        "safe": True, "outcome": "given up", "reason": "given up: contact was lost", "final_error_deg": 60.0, "error": None,
        "command": "doorman open push", "friction": 1.0, "success": False,
    }  # fmt: skip
    rows = [
        {"run": 0, "seed": 1, "told_truly": False, "summary.true_causes": json.dumps([LATCHED]), **common},
        {"run": 1, "seed": 2, "told_truly": None, "summary.true_causes": json.dumps([]), **common},
    ]
    found = figures(rows, 0.5)
    assert found["wrong_reasons"] == 1 and found["failures"][0]["true_causes"] == [LATCHED]
    text = page(rows, found, Scenario.load("push_campaign"), planned=2)
    assert (
        "stated reason is not the true one | 1 of 2 |" in text and f"True: {LATCHED}. The stated reason is not" in text
    )
    assert text.count("True:") == 1
