"""Figure of constraints and forces: what its curves hold, read back from the axes."""

import numpy as np
import pytest
from paper_door import door_normal
from simple_flight import fly

from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.recording import Recording
from doorman.visualization import constraints_and_forces_figure, save


def curve(axes, label):
    (line,) = [line for line in axes.lines if line.get_label() == label]
    return np.asarray(line.get_xdata()), np.asarray(line.get_ydata())


def test_constraints_are_those_of_the_true_states(flight, model):
    figure = constraints_and_forces_figure(flight, model)
    truth = flight["truth"]
    shown = {line.get_label(): np.asarray(line.get_ydata()) for axes in figure.axes[:2] for line in axes.lines}
    for k in (0, 60, 200):
        state = [*truth["attitude"][k], truth["door_angle"][k], truth["door_rate"][k], *truth["arm_angles"][k]]
        values = model.constraints(state)
        for name, value in zip(model.constraint_names, values, strict=True):
            jamb_says_nothing = "jamb" in name and np.isnan(shown[name][k])  # the vehicle is before the doorway
            assert jamb_says_nothing or shown[name][k] == pytest.approx(value, abs=1e-9)
    assert all(np.isfinite(values).any() for values in shown.values())
    for axes in figure.axes[:2]:
        _, labels = axes.get_legend_handles_labels()
        assert "not allowed" in labels and f"planner's margin {model.scenario.planner.margin:g} m" in labels
        assert axes.get_ylabel().endswith("[m]") and axes.get_ylim()[1] > 0.0


def test_constraints_are_those_of_the_true_door(flight, model):
    proud = Model(model.scenario.replace({"simulation.door_face_offset": 0.03}))
    name = "disc clear of leaf"
    told, true = (curve(constraints_and_forces_figure(flight, one).axes[1], name)[1] for one in (model, proud))
    np.testing.assert_allclose(true - told, 0.03, atol=1e-12)


def test_constraints_fall_back_on_the_estimate(model):
    recording = fly(model, 0.3, with_truth=False)
    time, values = curve(constraints_and_forces_figure(recording, model).axes[1], model.constraint_names[-1])
    np.testing.assert_array_equal(time, recording["estimate"].time)
    np.testing.assert_allclose(values, model.constraints_along(recording["estimate"]["state"])[:, -1])


def test_forces_thrust_and_disturbance(flight, model):
    _, _, force, thrust, disturbance, _ = constraints_and_forces_figure(flight, model).axes
    np.testing.assert_array_equal(curve(force, "true")[1], flight["truth"]["tip_normal_force"])
    time, planned = curve(force, "planned")
    plan = flight["plan"]
    np.testing.assert_array_equal(time, plan.time)
    for k, (state, inputs) in enumerate(zip(plan["states"][:, 0], plan["input"], strict=True)):
        push = inputs[0] * rotation_body_to_world(state[:3]) @ [0.0, 0.0, 1.0]
        assert planned[k] == pytest.approx(door_normal(state[3]) @ push, abs=1e-9)  # n_D is level: the weight drops out
    assert planned.max() > 1.0 and planned.min() < -1.0
    assert curve(thrust, "limit")[1][0] == model.vehicle.max_thrust
    np.testing.assert_array_equal(curve(thrust, "commanded")[1], flight["command"]["thrust"])
    for k, name in enumerate("xyz"):
        np.testing.assert_array_equal(curve(disturbance, name)[1], flight["controller"]["disturbance"][:, k])
    assert all(axes.get_ylabel().endswith("[N]") for axes in (force, thrust, disturbance))


def test_solve_time_deadline_and_misses(flight, model):
    axes = constraints_and_forces_figure(flight, model).axes[-1]
    time, milliseconds = curve(axes, "solve")
    np.testing.assert_allclose(milliseconds, 1e3 * flight["plan"]["solve_time"])
    assert curve(axes, "deadline 10 ms")[1][0] == 10.0
    missed = flight["plan"]["deadline_missed"]
    assert 0 < missed.sum() < len(missed)
    np.testing.assert_array_equal(curve(axes, f"missed: {missed.sum()}")[0], time[missed])
    assert axes.get_ylabel().endswith("[ms]")


def test_topics_that_were_not_recorded_say_so(model, tmp_path):
    figure = constraints_and_forces_figure(Recording({}, {}), model)
    assert [axes.texts[0].get_text() for axes in figure.axes] == ["not recorded"] * 6
    save(figure, tmp_path, "constraints")
