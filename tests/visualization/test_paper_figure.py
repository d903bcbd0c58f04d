"""The paper's Fig. 4: panels in its order, and the flight of the task that reproduces it."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest
from urdf_variants import write_arm_of

from doorman import Model, Scenario, simulate
from doorman.exceptions import RecordingError
from doorman.visualization import paper_figure

DOCS = Path(__file__).parents[2] / "docs"


def test_panels_are_those_of_the_paper_in_degrees(flight, model):
    figure = paper_figure(flight, model)
    panels = {axes.get_ylabel(): axes for axes in figure.axes}
    left, right = (["φ", "θ", "ψ", "α"], [f"$\\eta_{{{joint}}}$" for joint in (1, 2, 3, 4)])
    assert list(panels) == [f"{name} [deg]" for pair in zip(left, right, strict=True) for name in pair]
    for place, name in zip([0, 1, 2, 3, 5, 6, 7, 8], [*left, *right], strict=True):
        measured, predicted, desired = panels[f"{name} [deg]"].lines
        np.testing.assert_allclose(measured.get_ydata(), np.degrees(flight["estimate"]["state"][:, place]))
        np.testing.assert_allclose(predicted.get_xdata(), flight["plan"].time + 0.2)
        np.testing.assert_allclose(predicted.get_ydata(), np.degrees(flight["plan"]["states"][:, 10, place]))
        np.testing.assert_allclose(desired.get_ydata(), np.degrees(model.goal_state[place]))
        assert (measured.get_color(), predicted.get_linestyle()) == ("#000000", "--")


def test_plans_with_other_states_are_refused(flight, tmp_path):
    urdf = write_arm_of(tmp_path / "arm.urdf", 3)
    other = Model(Scenario.load("paper", {"vehicle.urdf": str(urdf), "start.arm": [0.1] * 3, "goal.arm": [0.2] * 3}))
    with pytest.raises(RecordingError, match="planner.model"):
        paper_figure(flight, other)


def test_the_task_of_the_figure_goes_as_the_page_says():
    model = Model(Scenario.load("fig4"))
    recording = simulate(model, seed=0)
    rows = runpy.run_path(str(DOCS / "pictures" / "fig4.py"))["table"](recording, model).splitlines()
    page = (DOCS / "fig4.md").read_text(encoding="utf-8")
    assert [row.split("|")[:3] for row in rows] == [
        row.split("|")[:3] for row in page.splitlines() if row.startswith("|")
    ], "run: python docs/pictures/fig4.py"
    angle, yaw = np.degrees(recording["truth"]["door_angle"]), np.degrees(recording["truth"]["attitude"][:, 2])
    assert angle[0] == pytest.approx(90.0, abs=0.5) and angle[-1] == pytest.approx(20.0, abs=1.0)
    assert np.abs(yaw - (angle - 90.0)).max() < 25.0, "the heading follows the door"
    assert recording.summary["collisions"] == 0 and recording.summary["contact_fraction"] > 0.99
