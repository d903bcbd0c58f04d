"""Vehicles drawn by chance: what the check says of each, against geometry and statics that `random_vehicle` works out."""

from __future__ import annotations

from pathlib import Path

import pytest
from random_vehicle import RandomVehicle

from doorman import simulate
from doorman.feasibility import check
from doorman.feasibility.inputs.plant import plant_finding
from doorman.feasibility.inputs.setup import setup_findings
from doorman.feasibility.report import Severity
from doorman.feasibility.swing.geometry import geometry_findings
from doorman.model import Model

DRAWS = 100
FLOWN = sorted(
    [k for k in range(DRAWS) if RandomVehicle.drawn(k).possible][:20],
    key=lambda k: (RandomVehicle.drawn(k).joints, RandomVehicle.drawn(k).cant > 0.0),
)
"""Twenty that are possible; those with arms of as many joints follow each other, as they share kernels."""
FEW = {16, 30, 75}
"""That the short run looks at: arms of four joints, whose kernels the shipped vehicle has compiled, with and without a fault."""


def complaints(model: Model) -> list[str]:
    """Errors of the check that need no plan."""
    found = [*setup_findings(model), plant_finding(model), *geometry_findings(model)]
    return [f"{one.name}: {one.message}" for one in found if one.severity is Severity.ERROR]


@pytest.mark.parametrize("number", [pytest.param(k, marks=[] if k in FEW else pytest.mark.slow) for k in range(DRAWS)])
def test_the_check_is_right_without_a_plan(number: int, tmp_path: Path) -> None:
    vehicle = RandomVehicle.drawn(number)
    found = complaints(Model(vehicle.scenario(tmp_path)))
    assert (not found) is vehicle.possible, (vehicle, found)


@pytest.mark.slow
@pytest.mark.parametrize("number", FLOWN)
def test_what_is_possible_flies(number: int, tmp_path: Path) -> None:
    """Every combination of joints and kind of rotors has kernels of its own to compile: minutes each."""
    model = Model(RandomVehicle.drawn(number).scenario(tmp_path))
    report = check(model)
    assert report.possible, [finding.words for finding in report.complaints]
    summary = simulate(model, seed=0, report=report).summary
    assert summary is not None and summary["outcome"] == "completed" and not summary["collisions"], summary
    assert abs(summary["final_error"]) < 2.0, summary["final_error"]
