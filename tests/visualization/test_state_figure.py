"""Figure of the states: what its curves hold, read back from the axes."""

import os
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from simple_flight import fly

from doorman.exceptions import RecordingError
from doorman.recording import Recorder, Recording
from doorman.visualization import save, states_figure


def lines(axes, label):
    return [line for line in axes.lines if line.get_label() == label]


def test_measured_predicted_and_desired_curves(flight, model):
    figure = states_figure(flight, model)
    panels = figure.axes
    assert len(panels) == model.nx
    plan = flight["plan"]
    for i, axes in enumerate(panels):
        wanted = "desired" if i in (3, 4) else "preferred, one cost among others"
        (measured,), (predicted,), (desired,) = (lines(axes, name) for name in ("measured", "predicted", wanted))
        assert predicted.get_linewidth() < measured.get_linewidth()
        np.testing.assert_array_equal(measured.get_xdata(), flight["estimate"].time)
        np.testing.assert_allclose(measured.get_ydata(), np.degrees(flight["estimate"]["state"][:, i]))
        np.testing.assert_allclose(predicted.get_xdata(), plan.time + 0.2)
        np.testing.assert_allclose(predicted.get_ydata(), np.degrees(plan["states"][:, 10, i]))
        np.testing.assert_allclose(desired.get_ydata(), np.degrees(model.goal_state[i]))
        assert (measured.get_color(), measured.get_linestyle()) == ("#000000", "-")
        assert predicted.get_linestyle() == "--"
        assert len({measured.get_color(), predicted.get_color(), desired.get_color()}) == 3
        assert axes.get_ylabel().endswith("[deg/s]" if i == 4 else "[deg]")
    assert [axes.get_ylabel().split()[0] for axes in panels[:5]] == ["φ", "θ", "ψ", "α", "α̇"]
    assert [axes.get_xlabel() for axes in panels[-3:]] == ["time [s]"] * 3


def test_predictions_meet_what_happened(flight, model):
    """The recorded plans come from the model that moved: a prediction is the truth of its time."""
    figure = states_figure(flight, model)
    for axes, truth in zip(figure.axes, np.degrees(flight["truth"]["attitude"]).T, strict=False):
        (predicted,) = lines(axes, "predicted")
        time = predicted.get_xdata()
        known = time <= flight["truth"].time[-1]
        there = np.interp(time, flight["truth"].time, truth)
        np.testing.assert_allclose(np.asarray(predicted.get_ydata())[known], there[known], atol=1e-6)


def test_whole_horizons_start_at_their_plans(flight, model):
    axes = states_figure(flight, model).axes[3]
    horizons = lines(axes, "horizon")
    assert len(horizons) == 6
    for line in horizons:
        k = int(np.argmin(np.abs(flight["plan"].time - line.get_xdata()[0])))
        np.testing.assert_allclose(line.get_ydata(), np.degrees(flight["plan"]["states"][k, :, 3]))
        np.testing.assert_allclose(np.diff(line.get_xdata()), 0.02)
    assert all(a.get_xdata()[0] < b.get_xdata()[0] for a, b in pairwise(horizons))


def test_truth_is_drawn_only_where_it_differs(flight, model):
    drawn = [bool(lines(axes, "truth")) for axes in states_figure(flight, model).axes]
    assert drawn == [i in (1, 3) for i in range(model.nx)]
    (truth,) = lines(states_figure(flight, model).axes[3], "truth")
    np.testing.assert_allclose(truth.get_ydata(), np.degrees(flight["truth"]["door_angle"]))
    (measured,) = lines(states_figure(flight, model).axes[3], "measured")
    assert truth.get_linewidth() < measured.get_linewidth()


def test_a_true_heading_near_the_half_turn_does_not_jump(model):
    flight = Recorder(None, {})
    headings = np.pi + 0.05 * np.array([-1.0, 1.0, -1.0, 1.0])
    for k, heading in enumerate(headings):
        flight.write("estimate", 0.1 * k, {"state": np.array([0.0, 0.0, heading, *model.start_state[3:]])})
        wrapped = (heading + 0.01 + np.pi) % (2.0 * np.pi) - np.pi
        flight.write("truth", 0.1 * k, {
            "attitude": [0.0, 0.0, wrapped], "door_angle": model.start_state[3], "door_rate": 0.0,
            "arm_angles": model.start_state[5:],
        })  # fmt: skip
    (truth,) = lines(states_figure(flight.recording(), model).axes[2], "truth")
    np.testing.assert_allclose(truth.get_ydata(), np.degrees(headings + 0.01))


def test_a_flight_without_truth_and_plan(model):
    figure = states_figure(fly(model, 0.2, with_truth=False, with_plan=False), model)
    assert [line.get_label() for line in figure.axes[3].lines] == ["measured", "desired"]
    assert [line.get_label() for line in figure.axes[0].lines] == ["measured", "preferred, one cost among others"]


def test_a_single_tick_and_values_that_are_not_finite(model, tmp_path):
    recorder = Recorder(None, {})
    recorder.write("estimate", 0.0, {"state": np.full(model.nx, np.nan)})
    png, pdf = save(states_figure(recorder.recording(), model), tmp_path / "new" / "folder", "states")
    assert png.read_bytes().startswith(b"\x89PNG") and pdf.read_bytes().startswith(b"%PDF")
    assert (png.name, pdf.name) == ("states.png", "states.pdf") and png.stat().st_size > 1000


def test_no_estimate_is_an_error(model):
    with pytest.raises(RecordingError, match="estimate"):
        states_figure(Recording({}, {}), model)


def test_neither_windows_nor_servers_are_loaded():
    check = "import sys, doorman.visualization; print([m for m in ('matplotlib.pyplot', 'meshcat', 'zmq') if m in sys.modules])"
    result = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, timeout=60, check=True)
    assert result.stdout == "[]\n"


def test_missing_matplotlib_says_what_to_install():
    check = (
        "import sys; sys.modules['matplotlib'] = sys.modules['matplotlib.axes'] = None\n"
        "from doorman.exceptions import DoormanError\n"
        "try:\n    import doorman.visualization\nexcept DoormanError as error:\n    print(error)"
    )
    result = subprocess.run([sys.executable, "-c", check], capture_output=True, text=True, timeout=60, check=True)
    assert "pip install -e '.[viz]'" in result.stdout


@pytest.mark.parametrize("name", ["a $x^ b$", "$\\frac$ α"])
def test_names_are_no_mathematics(model, tmp_path, name):
    recording = fly(model, 0.1)
    figure = states_figure(Recording(dict(recording), {"name": name}), model)
    figure.savefig(tmp_path / "states.png", dpi=20)


def test_a_backend_that_does_not_exist_is_not_needed():
    code = """
import os, doorman.visualization.style as style
style.Figure()
import matplotlib
assert os.environ["MPLBACKEND"] == "nonsense" != matplotlib.rcParams["backend"]
"""
    subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "MPLBACKEND": "nonsense"}, check=True,
        timeout=120,
    )  # fmt: skip
