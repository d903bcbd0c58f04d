"""What in truth may explain a failure, from flights of the plant alone, without a mission."""

from __future__ import annotations

import math

import numpy as np
import pytest

from doorman.hardware.interface import Command
from doorman.recording import Recorder
from doorman.simulation import SimulatedBackend
from doorman.simulation.reality import causes
from doorman.simulation.reality.causes import true_causes


def flown(model, seconds: float = 0.3, pitch: float = 0.0, **keys: object) -> list[str]:
    """Causes of a hover, or of one that leans on the leaf and holds it."""
    scene, recorder = model(**keys), Recorder(None, {})
    with SimulatedBackend(scene, recorder=recorder) as backend:
        for _ in range(round(seconds * 250)):
            backend.read()
            backend.command(Command(3.0 * 9.81, np.array([0.0, pitch, 0.0]), np.zeros(4), grip=True))
    return true_causes(recorder.recording(), scene)


@pytest.mark.parametrize("kind", ["grip", "push"])
def test_nothing_is_wrong_by_default(model, kind):
    assert flown(model, contact__kind=kind) == []


def test_a_gripper_that_slips_or_never_closes(model):
    pulled = {"pitch": -0.3, "simulation__door_friction": 50.0, "seconds": 0.8}
    assert flown(model, simulation__gripper_force=2.0, **pulled) == [causes.SLIPPED]
    assert flown(model, **pulled) == []
    assert flown(model, simulation__gripper_force=0.0) == [causes.NEVER_CLOSED]
    assert flown(model, contact__kind="push", simulation__gripper_force=0.0) == []


@pytest.mark.parametrize(
    ("keys", "cause"),
    [
        ({"door_offset": (0.0, 0.0, 0.02)}, causes.ELSEWHERE), ({"door_yaw": -0.03}, causes.ELSEWHERE),
        ({"gust__vehicle": 4.0, "gust__variation": 0.0}, causes.WIND), ({"gust__draught": -3.0}, causes.DRAUGHT),
        ({"thrust_scale": 0.9}, causes.WEAK), ({"vehicle_mass": 3.4}, causes.WEAK),
        ({"noise__position": 0.001}, causes.NOISY),
        ({"sensors__latency": 0.05}, causes.LATE), ({"sensors__drift": 0.05}, causes.FRAME),
    ],
)  # fmt: skip
def test_each_cause_is_told_by_itself(model, keys, cause):
    scene = {f"simulation__{name}": value for name, value in keys.items()}
    assert flown(model, contact__kind="push", mission__start="hover", **scene) == [cause]


@pytest.mark.parametrize(("catch", "cause"), [("door_latch", causes.LATCHED), ("door_seal", causes.SEALED)])
def test_latch_and_seal_hold_only_a_leaf_that_the_tip_pushes(model, catch, cause):
    held = {"contact__kind": "push", f"simulation__{catch}": 50.0}
    assert flown(model, pitch=0.1, **held) == [cause]
    assert flown(model, mission__start="hover", **held) == []


def test_a_latch_that_was_overcome_held_nothing(model):
    held = {"simulation__door_latch": 50.0, "simulation__door_seal": 3.0}
    assert flown(model, start__door_angle=math.pi / 2 - 0.3, **held) == [], "a tip that grips touches"
