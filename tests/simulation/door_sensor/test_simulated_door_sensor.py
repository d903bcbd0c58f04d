"""Simulated sensors of the door: rate, delay, noise, gaps, what a camera sees, what lies, and the detector on pictures."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from doorman.door_sensor.printing import usual_camera, usual_marks
from doorman.hardware.door import LeafGeometry
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.scenario.sections.door_sensor import DoorSensorSection
from doorman.simulation import SimulatedBackend
from doorman.simulation.door_sensor.simulated import Seen, SimulatedDoorSensor
from doorman.simulation.simulator import Simulator

TICK = 0.004
KEY = "simulation.door_sensor."


def model_with(name: str = "push", **keys) -> Model:
    elsewhere = {"simulation.door_offset": (0.02, -0.01, 0.0), "simulation.door_yaw": 0.03}
    return Model(Scenario.load(name, {**elsewhere, **{KEY + key: value for key, value in keys.items()}}))


def readings(model: Model, opening=lambda time: 0.1 * time, ticks: int = 500, view=None):
    """Leaf and frame at every tick, and the true joint value."""
    sensor, truth = SimulatedDoorSensor(model, 3, view), Simulator(model, 1e-3).truth()
    for k in range(ticks):
        time = k * TICK
        angle = model.true_door.angle_of_opening(opening(time))
        yield time, *sensor.measure(replace(truth, time=time, door_angle=angle)), model.true_door.joint_value(angle)


@pytest.mark.parametrize(
    ("kind", "rate", "latency"), [("cameras", 100.0, 0.02), ("tags", 30.0, 0.06), ("encoder", 250.0, 0.004)]
)
def test_readings_have_rate_delay_and_noise(kind, rate, latency):
    model = model_with(kind=kind)
    seen = {leaf.time: (time, leaf) for time, leaf, _, _ in reversed(list(readings(model))) if leaf is not None}
    assert len(seen) == pytest.approx(rate * (2.0 - latency), rel=0.05)
    assert min(came - at for at, (came, _) in seen.items()) == pytest.approx(latency, abs=TICK)
    errors = [
        leaf.joint - model.true_door.joint_value(model.true_door.angle_of_opening(0.1 * at))
        for at, (_, leaf) in seen.items()
    ]
    deviation = next(iter(seen.values()))[1].deviation
    assert np.std(errors) == pytest.approx(deviation, rel=0.35) and 5e-4 < deviation < 0.01


def test_the_frame_is_measured_where_it_truly_stands():
    model = model_with(kind="cameras")
    found = [frame for _, _, frame, _ in readings(model) if frame is not None]
    hinge = np.mean([frame.placed(model.door.hinge_position) for frame in found], axis=0)
    np.testing.assert_allclose(hinge, model.true_door.hinge_position, atol=1e-3)
    assert np.mean([frame.yaw for frame in found]) == pytest.approx(0.03, abs=2e-3)
    assert all(frame is None for _, _, frame, _ in readings(model_with(kind="encoder"), ticks=50))


def test_what_is_hidden_is_not_measured():
    hidden = list(readings(model_with(kind="tags"), view=lambda truth: Seen(truth.time < 0.5, True)))
    assert any(leaf for _, leaf, _, _ in hidden[:200]) and not any(leaf for time, leaf, _, _ in hidden if time > 0.9)


@pytest.mark.parametrize("fault", ["freeze", "jump", "late", "upside_down", "wrong_object", "dies"])
def test_a_sensor_lies_from_an_opening_on(fault):
    model = model_with(kind="encoder", fault=fault, fault_opening=0.1)
    run = [(time, leaf and leaf.joint - true) for time, leaf, _, true in readings(model)]
    before = [abs(off) for time, off in run[5:250] if off is not None]
    after = [off for time, off in run[400:] if off is not None]
    assert max(before) < 0.03
    assert not after if fault == "dies" else max(map(abs, after)) > 0.02


def test_a_camera_sees_the_leaf_it_hovers_before_and_nothing_beside_its_field_of_view(monkeypatch):
    model = model_with(kind="tags")
    backend = SimulatedBackend(model, seed=1)
    with backend:
        for _ in range(30):
            measured = backend.read()
    assert measured.leaf is not None and measured.frame is not None
    monkeypatch.setattr(DoorSensorSection, "field_of_view", 0.05)
    with (blind := SimulatedBackend(model, seed=1)):
        assert all((one := blind.read()).leaf is None and one.frame is None for _ in range(30))


def test_marks_are_where_their_words_say():
    model = Model(Scenario.load("push"))
    leaf, frame = usual_marks(model)
    door = model.door
    link = door.link_placements(0.5 * math.pi)[door.section.leaf]
    place = door.in_doorway((link @ [*leaf.position, 1.0])[:3] - door.hinge_position)
    assert place[0] == pytest.approx(-door.surface_offset) and 0.1 < place[1] < door.width - 0.1
    beside = door.in_doorway(np.array(frame.position) - door.hinge_position)
    assert beside[1] > door.width and beside[0] <= 0.0
    assert LeafGeometry.of(door).placement(door.joint_value(1.0))[0] == pytest.approx(
        door.link_placements(1.0)[door.section.leaf][:3, 3]
    )


def test_the_real_detector_reads_rendered_pictures():
    """Needs EGL: .ci/run installs it; what has none says what it needs."""
    from doorman.exceptions import BackendError
    from doorman.simulation.door_sensor.pictures import PictureSensor
    from doorman.simulation.plant.engine import engine

    model = model_with(kind="pictures")
    simulator = Simulator(model, 1e-3)
    marks, camera = usual_marks(model), usual_camera(math.radians(70.0))
    try:
        pictures = PictureSensor(engine(), simulator, marks, camera, 0)
    except BackendError as error:
        assert "libegl1" in str(error)
        return
    truth = simulator.truth()
    leaf, frame = pictures.look(0.0, truth.position, truth.attitude)
    pictures.close()
    assert leaf.joint == pytest.approx(model.true_door.joint_value(truth.door_angle), abs=math.radians(0.7))
    np.testing.assert_allclose(
        frame.placed(model.door.hinge_position)[:2], model.true_door.hinge_position[:2], atol=0.02
    )
    assert frame.yaw == pytest.approx(0.03, abs=math.radians(1.5))
