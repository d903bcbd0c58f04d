"""What the rig's truth shows of a flight, whoever flew it; in the plant's time, which passes by `advance`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from doorman.model import Model
from doorman.recording import Recorder
from doorman.rig import RigPlant
from doorman.rig.witness import Witness, verdict
from doorman.scenario import Scenario

MODEL = Model(Scenario.load("push"))
LEVEL = np.zeros(3)
OPEN = MODEL.true_door.joint_value(MODEL.goal_angle)


class Watched:
    """A plant, and who watches it."""

    def __init__(self) -> None:
        self.witness = Witness(MODEL)
        self.plant = RigPlant(MODEL, Recorder(None, {}, self.witness.note, keep=False))
        self.level = np.array([0.0, 0.0, self.plant.places.yaw])

    def fly(self, share: float, seconds: float) -> None:
        """With this share of the weight as thrust."""
        self.plant.fly(share * MODEL.vehicle.weight, self.level)
        self.wait(seconds)

    def land(self) -> None:
        self.plant.stop_motors()
        self.wait(1.0)

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds / self.plant.period)):
            self.plant.advance()

    def put_door(self, joint_value: float) -> None:
        plant = self.plant._simulator.plant
        plant.data.qpos[plant.hinge_position] = joint_value

    def put_vehicle(self, *place: float) -> None:
        self.plant._simulator.plant.data.qpos[:3] = place
        self.plant._simulator.plant.data.qvel[:6] = 0.0

    @property
    def figures(self) -> dict:
        return self.witness.judged(self.plant.snapshot)


@pytest.fixture
def watched() -> Watched:
    return Watched()


def test_an_opened_door_and_a_vehicle_that_stands_again_are_good(watched: Watched) -> None:
    watched.fly(1.1, 0.5)
    watched.put_door(OPEN)
    watched.land()
    good, sentence = verdict(watched.figures)
    assert good and "was opened" in sentence, sentence
    assert watched.figures["final_door_angle_deg"] == pytest.approx(math.degrees(MODEL.goal_angle), abs=0.1)


def not_flown(watched: Watched) -> None:
    watched.put_door(OPEN)
    watched.wait(0.1)


def shut(watched: Watched) -> None:
    watched.fly(1.1, 0.3)
    watched.land()


def still_flies(watched: Watched) -> None:
    watched.fly(1.1, 0.3)
    watched.put_door(OPEN)
    watched.wait(0.05)


def door_swings(watched: Watched) -> None:
    watched.fly(1.1, 0.3)
    watched.put_door(OPEN)
    watched.land()
    watched.fly(0.5, 0.02)
    watched.plant.kick(0.3)
    watched.fly(0.5, 0.03)
    watched.plant.stop_motors()
    watched.put_door(OPEN)
    watched.plant.advance()


def touches(watched: Watched) -> None:
    watched.fly(1.1, 0.3)
    watched.put_door(OPEN)
    watched.put_vehicle(-0.3, -0.5, 1.2)  # the disc in the wall
    watched.fly(1.0, 0.1)
    watched.put_vehicle(*watched.plant.places.pad)
    watched.land()


@pytest.mark.parametrize(
    ("flight", "words"),
    [(not_flown, "Nothing was flown"), (shut, "was not opened"), (still_flies, "not landed"), (door_swings, "was not opened"),
     (touches, "touched")],
)  # fmt: skip
def test_what_is_not_good_is_told(watched: Watched, flight: Callable[[Watched], None], words: str) -> None:
    flight(watched)
    good, sentence = verdict(watched.figures)
    assert not good and words in sentence, sentence


def test_what_touched_what_is_named_with_its_time(watched: Watched) -> None:
    touches(watched)
    first = min(watched.figures["touched"], key=lambda one: one["first_s"])
    assert "wall" in first["pair"] or "frame" in first["pair"] or "door" in first["pair"], first
    assert 0.0 < first["duration_s"] < 0.2 and first["first_s"] == pytest.approx(0.3, abs=0.02)


def test_sinking_counts_at_the_leaf_alone(watched: Watched) -> None:
    watched.fly(1.0, 0.1)
    truth, witness = watched.plant.snapshot.truth, watched.witness
    heights = [(1.3, False), (1.2, True), (1.15, True), (1.13, False), (1.2, True), (1.2, False)]
    for tick, (height, touching) in enumerate(heights):
        position = np.array([*truth.position[:2], height])
        witness.note("truth", 10.0 + 0.2 * tick, replace(truth, position=position, touching=touching).fields())
    low = replace(truth, position=np.array([*truth.position[:2], 0.3]), touching=False)
    witness.note("truth", 20.0, low.fields())
    assert watched.figures["max_sinking_m"] == pytest.approx(0.07)
