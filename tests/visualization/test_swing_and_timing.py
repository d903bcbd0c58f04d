"""Figures of the swing from above and of the planner's time, and the phases behind curves: read back from the axes."""

import numpy as np
import pytest
from matplotlib.patches import Circle
from simple_flight import fly

from doorman.exceptions import RecordingError
from doorman.model import Model
from doorman.recording import Recorder, Recording
from doorman.summary.figures import planner_figures
from doorman.visualization import constraints_and_forces_figure, planner_time_figure, save, states_figure, swing_figure
from doorman.visualization.figures.phases import phases, tied


def leaves(axes):
    """Ends of the leaves, by their labels."""
    return {str(line.get_label()): line.get_xydata()[1] for line in axes.lines if "° at " in str(line.get_label())}


def test_leaf_and_disc_stand_where_they_were(flight, model):
    (axes,) = swing_figure(flight, model).axes
    truth = flight["truth"]
    drawn = leaves(axes)
    assert len(drawn) >= 5
    for label, end in drawn.items():
        angle, time = (float(word.strip("°s ")) for word in label.split(" at "))
        there = np.interp(time, truth.time, truth["door_angle"])
        assert np.degrees(there) == pytest.approx(angle, abs=3.0)  # the label's time is rounded to 0.1 s
        np.testing.assert_allclose(np.degrees(np.arctan2(end[1], end[0])), angle, atol=0.6)
        assert np.hypot(*end) == pytest.approx(model.door.width)
    circles = [patch for patch in axes.patches if isinstance(patch, Circle)]
    assert len(circles) == 2 * len(drawn) and {circle.radius for circle in circles} == {model.vehicle.radius}
    start = truth["position"][0] - model.door.hinge_position
    np.testing.assert_allclose(circles[0].center, start[:2], atol=1e-6)
    assert axes.get_xlabel().endswith("[m]") and axes.get_ylabel().endswith("[m]") and axes.get_aspect() == 1.0


def test_the_tips_path_keeps_its_distance_from_the_hinge(flight, model):
    (axes,) = swing_figure(flight, model).axes
    (tip,) = [line.get_xydata() for line in axes.lines if line.get_label() == "tip's path"]
    np.testing.assert_allclose(np.hypot(*tip.T), model.scenario.contact.distance_from_hinge, atol=2e-3)


def test_the_swing_is_seen_from_the_true_doorway(flight, model):
    """A motion beside a door that stands elsewhere, turned and proud, in the axes of that door."""
    yaw, offset, face = 0.3, np.array([0.1, -0.2, 0.0]), 0.04
    keys = {"simulation.door_yaw": yaw, "simulation.door_offset": offset, "simulation.door_face_offset": face}
    (axes,) = swing_figure(flight, Model(model.scenario.replace(keys))).axes
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    (path,) = [line.get_xydata() for line in axes.lines if line.get_label() == "vehicle's path"]
    away = (flight["truth"]["position"][0] - model.door.hinge_position - offset)[:2]
    np.testing.assert_allclose(turn @ path[0], away, atol=1e-9)
    for label, end in leaves(axes).items():
        angle = np.radians(float(label.split("°")[0]))
        before = end @ [-np.sin(angle), np.cos(angle)]
        assert before == pytest.approx(face, abs=0.012), "the label's angle is rounded to 1°"


def test_a_flight_without_motion_has_no_swing(model):
    with pytest.raises(RecordingError, match="truth"):
        swing_figure(Recording({}, {}), model)


def test_the_histogram_counts_every_plan(flight, model):
    (axes,) = planner_time_figure(flight, model).axes
    plan = flight["plan"]
    assert sum(patch.get_height() for patch in axes.patches[:-1]) == len(plan.time)
    labels = axes.get_legend_handles_labels()[1]
    assert f"deadline 10 ms, late: {int(plan['deadline_missed'].sum())}" in labels
    median = 1e3 * np.median(plan["solve_time"])
    assert f"50 %: {median:.2f} ms" in labels
    assert axes.get_xlabel().endswith("[ms]")


@pytest.mark.parametrize("cold", [(0,), (0, 3, 4), (), range(6)])
def test_the_histogram_has_the_quantiles_of_the_summary(model, cold):
    times = [0.02, 0.001, 0.002, 0.03, 0.004, 0.0005]
    recorder = Recorder(None, {})
    for k, time in enumerate(times):
        fields = {"solve_time": time, "deadline_missed": False, "cold": k in cold, "least_normal_force": 0.0}
        recorder.write("plan", 0.01 * k, fields)
    recording = recorder.recording()
    figures = planner_figures(recording)["planner_ms"]
    labels = planner_time_figure(recording, model).axes[0].get_legend_handles_labels()[1]
    told = " ".join(labels)
    if figures["median"] is None:
        assert "50 %" not in told and "warm: 0" in told
    else:
        assert f"50 %: {figures['median']:.2f} ms" in labels and f"99 %: {figures['p99']:.2f} ms" in labels
        assert f"warm: {6 - len(cold)}, at most {figures['max']:.2f} ms" in labels
    cold_ones = f"cold: {len(cold)}" + (f", at most {figures['cold']:.2f} ms" if len(cold) else "")
    assert cold_ones in labels


def test_plans_that_were_not_recorded_are_said_to_be_missing(model):
    figure = planner_time_figure(fly(model, 0.2, with_plan=False), model)
    assert [text.get_text() for text in figure.axes[0].texts] == ["not recorded"]


def test_phases_are_named_above_the_states(flight, model):
    assert phases(flight, 5.0) == [("touch", 0.0, 0.4), ("open", 0.4, 5.0)]
    panels = states_figure(flight, model).axes
    for axes in panels[:3]:
        assert [text.get_text() for text in axes.texts] == ["touch", "open"]
    for axes in panels:
        assert [(patch.get_x(), patch.get_width()) for patch in axes.patches[:2]] == [
            (0.0, pytest.approx(0.4)), (0.4, pytest.approx(flight["estimate"].time[-1] - 0.4))
        ]  # fmt: skip


def test_constraints_are_drawn_while_the_tip_is_at_the_door(flight, model):
    recorder = Recorder(None, {})
    for k, time in enumerate(flight["truth"].time[:150]):
        recorder.write("truth", time, {name: flight["truth"][name][k] for name in flight["truth"]})
    for time, state in ((0.0, "hover"), (1.0, "open"), (2.0, "retreat")):
        recorder.write("mission", time, {"state": state, "message": ""})
    recording = recorder.recording()
    there = tied(recording, np.array([0.5, 1.5, 2.5]))
    assert there.tolist() == [False, True, False]
    line = constraints_and_forces_figure(recording, model).axes[0].lines[0]
    np.testing.assert_array_equal(np.isfinite(line.get_ydata()), tied(recording, line.get_xdata()))


def test_the_estimated_force_is_drawn_beside_the_true_one(flight, model):
    recorder = Recorder(None, {})
    for time in (0.0, 0.1):
        recorder.write("estimate", time, {"state": model.start_state, "normal_force": 2.0 + time})
    force = constraints_and_forces_figure(recorder.recording(), model).axes[2]
    (line,) = [line for line in force.lines if line.get_label() == "estimated"]
    assert line.get_ydata().tolist() == [2.0, 2.1]


@pytest.mark.parametrize("draw", [swing_figure, constraints_and_forces_figure, states_figure, planner_time_figure])
def test_nothing_is_cut_off_at_the_papers_edge(draw, flight, model, tmp_path):
    figure = draw(flight, model)
    save(figure, tmp_path, "figure")
    drawn, (width, height) = figure.get_tightbbox(), figure.get_size_inches()
    assert drawn.x0 >= 0.0 and drawn.y0 >= 0.0 and drawn.x1 <= width and drawn.y1 <= height
