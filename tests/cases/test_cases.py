"""Small files that were once read, judged or flown wrongly, each with the right answer, through the doors that users have."""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import assert_bad_input, run

from doorman import Scenario, simulate
from doorman.feasibility import check

CASES = Path(__file__).parent


@pytest.mark.parametrize(
    ("file", "words"),
    [
        ("doors/latched", ["joint latch", "does not open a latched door"]),
        ("vehicles/vel0", ["eta_1/limit@velocity", "cannot move"]),
        ("files/huge_box", ["box@size", "up to 1000"]),
        ("files/deep", ["nested too deep", "up to 32 tables"]),
        ("files/huge_int", ["planner.margin", "4096 bits"]),
    ],
)
def test_a_file_that_cannot_be_is_one_line_that_names_the_field(file: str, words: list[str]) -> None:
    assert_bad_input(run("check", str(CASES / f"{file}.toml")), f"{Path(file).name}.", *words)


def test_a_byte_order_mark_is_no_part_of_the_first_table() -> None:
    assert Scenario.load(CASES / "files" / "r12_bom.toml").contact.distance_from_hinge == 0.65


@pytest.mark.slow
@pytest.mark.parametrize(
    "file",
    [
        *(
            f"doors/{name}"
            for name in ("left", "pull", "leaf_along_y", "closed_at_zero", "off50", "tilt0.05", "drawer")
        ),
        *(f"vehicles/{name}" for name in ("heavy_arm", "arm_continuous", "arm_telescope", "arm_on_top")),
        *(f"vehicles/{name}" for name in ("rotors_continuous", "rotors_tilted")),
        "rotors/task",
    ],
)
def test_what_can_be_flown_is_possible(file: str) -> None:
    assert check(CASES / f"{file}.toml").possible


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "finding"),
    [
        ("doors/valve", "room along the swing"),
        ("doors/hatch", "force on the door"),
        ("doors/contact_near_latch", "room along the swing"),
        ("vehicles/stick", "reach"),
        ("hollow/task", "hull of frame"),
    ],
)
def test_what_cannot_be_flown_is_refused_with_its_reason(file: str, finding: str) -> None:
    report = check(CASES / f"{file}.toml")
    assert not report.possible
    assert finding in {row.name for row in report.errors}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("file", "most_off", "seed"),
    [
        ("doors/left", 0.6, 0),
        ("doors/off50", 0.6, 0),
        ("doors/tilt0.05", 1.0, 0),
        ("doors/drawer", 1.0, 0),
        ("contact/proud_push", 1.0, 0),
        ("contact/proud_grip", 1.0, 0),
        ("contact/grip_closer", 2.0, 0),
        ("contact/mocap_40ms_100hz", 1.5, 5),
    ],
)
def test_it_opens_untouched(file: str, most_off: float, seed: int) -> None:
    """Degrees, or centimetres of a drawer, from the goal; never more than 15 N on the door."""
    summary = simulate(CASES / f"{file}.toml", seed=seed).summary
    assert summary["outcome"] == "completed"
    assert abs(summary["final_error"]) <= most_off
    assert summary["collisions"] == 0
    assert summary["max_push_force_n"] < 15.0


@pytest.mark.slow
def test_the_torque_that_is_called_true_has_the_closers_preload() -> None:
    """1 N m where the door is closed, 0.5 N m of friction, and what the swing adds."""
    torque = simulate(CASES / "contact" / "preload_push.toml").summary["estimates"]["torque"]
    assert torque["true"] > 1.5
    assert abs(torque["value"] - torque["true"]) < 2.0 * torque["deviation"]
