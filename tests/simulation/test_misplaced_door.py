"""A door that truly stands elsewhere than it is believed to: the plant, the tip on it, and the wind."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.exceptions import ScenarioError
from doorman.hardware.interface import Command
from doorman.simulation import SimulatedBackend

YAW, FACE = 0.06, 0.04
ELSEWHERE = {
    "simulation__door_offset": (0.02, -0.03, 0.01),
    "simulation__door_yaw": YAW,
    "simulation__door_face_offset": FACE,
}


def normal(angle: float) -> np.ndarray:
    return np.array([math.sin(angle), -math.cos(angle), 0.0])


def on_face(point: np.ndarray, door_angle: float) -> float:
    """Distance of a point behind the true face, by hand from the keys of `ELSEWHERE` [m]."""
    return float(normal(door_angle + YAW) @ (point - [0.02, -0.03, 0.41])) + FACE


def test_the_engines_leaf_and_frame_stand_where_the_true_door_says(flight):
    plant = flight(contact__kind="push", **ELSEWHERE)
    for angle in (math.pi / 2, 0.9):
        plant.data.qpos[plant.plant.hinge_position] = angle
        plant.simulator._mujoco.mj_kinematics(plant.plant.engine_model, plant.data)
        for link, placement in plant.model.true_door.link_placements(angle).items():
            body = plant.data.body(f"door/{link}")
            np.testing.assert_allclose(body.xpos, placement[:3, 3], atol=1e-9)
            np.testing.assert_allclose(body.xmat.reshape(3, 3), placement[:3, :3], atol=1e-9)


@pytest.mark.parametrize("kind", ["push", "grip"])
def test_a_tip_that_begins_at_the_leaf_touches_the_true_one(flight, kind):
    begun = flight(contact__kind=kind, **ELSEWHERE)
    angle = begun.model.start_angle
    tip = np.array(begun.data.site("tip").xpos)
    ball = 0.0 if kind == "grip" else on_face(tip, angle)
    assert ball <= 0.0 and on_face(tip, angle) == pytest.approx(ball, abs=1e-9)
    believed = begun.model.door.contact_point(angle, 0.7, 0.8)
    beside = np.array([math.cos(angle + YAW), math.sin(angle + YAW), 0.0])
    assert beside @ (tip - believed) == pytest.approx(0.0, abs=1e-9) and tip[2] == pytest.approx(believed[2])
    first = begun.run(0.001)[-1]
    assert np.abs(first.tip_force).max() < 1.0, "neither pressed into the leaf nor tied to a place elsewhere"
    assert begun.run(0.3, every=10)[-1].collisions == 0


def test_the_force_is_measured_along_the_true_normal(flight):
    pushing = flight(contact__kind="push", simulation__tip_friction=0.0, **ELSEWHERE)
    pushing.lean(3.0)
    end = pushing.run(0.4, every=400)[-1]
    assert end.touching and end.tip_normal_force > 1.0
    np.testing.assert_allclose(end.tip_force, end.tip_normal_force * normal(end.door_angle + YAW), atol=2e-3)


@pytest.mark.parametrize("kind", ["push", "grip"])
def test_a_hover_begins_where_the_door_is_believed(flight, kind):
    hover = {"contact__kind": kind, "mission__start": "hover"}
    told, other = flight(**hover).simulator.truth(), flight(**hover, **ELSEWHERE).simulator.truth()
    np.testing.assert_allclose(other.position, told.position, atol=1e-4)
    assert other.collisions == 0 and not other.touching


def test_a_flight_from_the_leaf_needs_one_there(model):
    beside = model(contact__kind="push", simulation__door_offset=(0.0, 0.9, 0.0))
    with pytest.raises(ScenarioError, match=r"simulation\.door_offset"):
        SimulatedBackend(beside).open()
    with SimulatedBackend(
        model(contact__kind="push", simulation__door_offset=(0.0, 0.9, 0.0), mission__start="hover")
    ) as backend:
        assert not backend.read().time


def test_a_jamb_is_met_where_it_truly_is(flight):
    """A vehicle between the jambs, 5 mm beside where its disc would meet the told latch jamb."""
    place = lambda begun: np.array([0.0, 1.2 - begun.model.vehicle.radius - 0.005, 1.4])  # noqa: E731

    def met(**true: object) -> set[str]:
        begun = flight(contact__kind="push", start__door_angle=0.2, start__arm=(0.0, 1.57, -1.57, 0.0), **true)
        begun.data.qpos[:3] += place(begun) - begun.simulator.truth().position
        begun.data.qpos[3:7] = [1, 0, 0, 0]
        begun.data.qvel[:] = 0
        return {pair for truth in begun.run(0.002) for pair in truth.collision_pairs if "jamb_latch" in pair}

    assert not met() and met(simulation__door_offset=(0.0, -0.02, 0.0))


def test_wind_turns_a_turned_leaf_by_its_own_direction(model):
    """A wind along the turned leaf does not turn it; along the told one it would."""
    along = {"contact__kind": "push", "simulation__gust__leaf": 2.0, "simulation__gust__variation": 0.0,
             "simulation__door_yaw": 0.3, "start__door_angle": 1.0, "mission__start": "hover"}  # fmt: skip
    rates = []
    for direction in (1.3, 1.0):
        with SimulatedBackend(model(**along, simulation__gust__direction=direction)) as backend:
            for _ in range(100):
                backend.read()
                backend.command(Command(3.0 * 9.81, np.zeros(3), np.zeros(4)))
            rates.append(backend.truth.door_rate)
    assert abs(rates[0]) < 1e-3
    assert rates[1] == pytest.approx(0.6 * 2.0 * math.sin(-0.3) / 5.28 * 0.396, rel=0.05)
