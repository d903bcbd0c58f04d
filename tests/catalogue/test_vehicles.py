"""Vehicles drawn by chance: what the check says of each, against geometry and statics that this file works out by itself.

Four to eight rotors on a ring, canted by 0 to 30° in turn, an arm of 0 to 6 joints, 0.8 to 8 kg. A draw may have what makes it
impossible: too little thrust, rotors that cannot turn it, an arm that does not reach beyond its disc, a door that resists with
more than a tilted vehicle pushes with, a doorway narrower than its disc. None is near the edge of that.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from urdf_variants import write_door

from doorman import simulate
from doorman.feasibility import check
from doorman.feasibility.inputs.plant import plant_finding
from doorman.feasibility.inputs.setup import setup_findings
from doorman.feasibility.report import Severity
from doorman.feasibility.swing.geometry import geometry_findings
from doorman.model import Model
from doorman.scenario import Scenario

GRAVITY = 9.81
TILT = 0.35
"""Of the task [rad]."""
FAULTS = ("", "", "", "thrust", "senses", "reach", "door", "doorway")


@dataclass(frozen=True)
class RandomVehicle:
    """One draw."""

    rotors: int
    cant: float
    """[rad]."""
    joints: int
    mass: float
    """Arm included [kg]."""
    fault: str
    """What is wrong with it; empty for nothing."""

    @classmethod
    def drawn(cls, number: int) -> RandomVehicle:
        """The draw of a number."""
        rng = np.random.default_rng([number, 46])
        rotors, joints = int(rng.integers(4, 9)), int(rng.integers(0, 7))
        cant = 0.0 if rng.random() < 0.4 else math.radians(float(rng.uniform(2.0, 30.0)))
        return cls(rotors, cant, joints, float(rng.uniform(0.8, 8.0)), FAULTS[number % len(FAULTS)])

    @property
    def radius(self) -> float:
        """R_A, of the size that a mass has [m]."""
        return 0.26 * self.mass ** (1.0 / 3.0)

    @property
    def senses(self) -> np.ndarray:
        """In which the rotors turn, shape (m,)."""
        alternate = np.where(np.arange(self.rotors) % 2 == 0, 1.0, -1.0)
        return np.ones(self.rotors) if self.fault == "senses" else alternate

    @property
    def places(self) -> np.ndarray:
        """Of the rotors, shape (m, 3) [m]."""
        turn = (np.arange(self.rotors) + 0.5) * 2.0 * math.pi / self.rotors
        return 0.69 * self.radius * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(self.rotors)])

    @property
    def axes(self) -> np.ndarray:
        """Of the thrusts, canted about the rotors' own arms to either side in turn, shape (m, 3)."""
        turn = (np.arange(self.rotors) + 0.5) * 2.0 * math.pi / self.rotors
        side = np.where(np.arange(self.rotors) % 2 == 0, 1.0, -1.0)
        if self.rotors % 2:  # no turn by turn: all upright
            side = np.zeros(self.rotors)
        a = side * self.cant
        return np.column_stack([-np.sin(a) * np.sin(turn), np.sin(a) * np.cos(turn), np.cos(a)])

    @property
    def largest(self) -> float:
        """Thrust of one rotor at its most [N]."""
        share = 1.02 if self.fault == "thrust" else 2.2
        return share * self.mass * GRAVITY / (self.rotors * float(self.axes[:, 2].mean()))

    @property
    def reach(self) -> float:
        """Of the arm, from the body's axis forward [m]."""
        return (0.75 if self.fault == "reach" else 1.45) * self.radius

    @property
    def contact(self) -> float:
        """Distance from the hinge at which it pushes [m]."""
        return 0.55 * self.door_width

    @property
    def door_width(self) -> float:
        """[m]."""
        return (1.5 if self.fault == "doorway" else 3.0) * self.radius

    @property
    def friction(self) -> float:
        """Of the hinge [N m]: a share of what the tilted vehicle turns it with."""
        most = self.mass * GRAVITY * math.tan(TILT) * self.contact
        return (1.5 if self.fault == "door" else 0.1) * most

    @property
    def possible(self) -> bool:
        """By geometry and statics: of what the rotors do, how far the arm reaches, and what the door takes."""
        axes, places = self.axes, self.places
        torques = np.cross(places, axes) - 0.016 * self.senses[:, None] * axes
        steering = np.vstack([axes[:, 2], torques.T])
        steers = np.linalg.matrix_rank(steering, tol=1e-6) == 4
        lifts = self.rotors * self.largest * axes[:, 2].mean() > 1.3 * self.mass * GRAVITY
        reaches = self.reach > self.radius + 0.1 * self.radius
        passes = self.door_width > 2.0 * self.radius * 1.1
        pushes = self.mass * GRAVITY * math.tan(TILT) * self.contact > 1.2 * self.friction
        return bool(steers and lifts and reaches and passes and pushes)

    def scenario(self, folder: Path) -> Scenario:
        """As a task: open a door of the vehicle's size by 70°."""
        vehicle = self._written(folder / "vehicle.urdf")
        leaf = 3.7 * self.mass
        door = write_door(folder / "door.urdf", width=self.door_width, height=4.0 * self.radius, mass=leaf)
        keys: dict[str, Any] = {
            "vehicle.urdf": str(vehicle), "door.urdf": str(door), "contact.distance_from_hinge": self.contact,
            "contact.height": 2.0 * self.radius, "planner.margin": 0.1 * self.radius,
            "door.friction": self.friction, "door.damping": 0.2 * self.friction,
            "simulation.door_friction": self.friction, "simulation.door_damping": 0.2 * self.friction,
            "control.max_door_disturbance": 3.0 * self.friction,
        }  # fmt: skip
        return Scenario.load("shipped:push", keys)

    def _written(self, path: Path) -> Path:
        robot = ElementTree.Element("robot", name="drawn")
        base = _link(robot, "base_link", 0.9 * self.mass, 0.35 * self.radius)
        collision = ElementTree.SubElement(base, "collision")
        ElementTree.SubElement(collision, "origin", xyz="0 0 0.0002")
        geometry = ElementTree.SubElement(collision, "geometry")
        ElementTree.SubElement(geometry, "cylinder", radius=str(self.radius), length="0.0004")
        for k, (place, axis, sense) in enumerate(zip(self.places, self.axes, self.senses, strict=True), 1):
            tilt = math.atan2(math.hypot(axis[0], axis[1]), axis[2])
            heading = math.atan2(axis[1], axis[0])
            turned = f"0 {tilt} {heading}"
            joint = _joint(robot, f"rotor_{k}", "fixed", "base_link", f"rotor_{k}", place, turned)
            ElementTree.SubElement(joint, "axis", xyz=f"0 0 {int(sense)}")
            ElementTree.SubElement(joint, "limit", effort=str(self.largest), velocity="900")
            ElementTree.SubElement(robot, "link", name=f"rotor_{k}")
        self._add_arm(robot)
        ElementTree.ElementTree(robot).write(path)
        return path

    def _add_arm(self, robot: ElementTree.Element) -> None:
        """A joint about −z below the body, then joints about −y whose links share the way ahead; none is a stick."""
        parent, torque = "base_link", 0.15 * self.mass * GRAVITY * self.radius * 4.0
        ahead = max(self.joints - 1, 1)
        for k in range(self.joints):
            first = np.array([0.0, 0.0, -0.1 * self.radius])
            offset = first if k == 0 else np.array([self.reach / ahead * (k > 1), 0.0, -0.1 * self.radius * (k == 1)])
            child = f"arm_{k + 1}"
            joint = _joint(robot, f"eta_{k + 1}", "revolute", parent, child, offset)
            ElementTree.SubElement(joint, "axis", xyz="0 0 -1" if k == 0 and self.joints > 1 else "0 -1 0")
            ElementTree.SubElement(joint, "limit", lower="-1.8", upper="1.8", effort=str(torque), velocity="3.0")
            _link(robot, child, 0.1 * self.mass / self.joints, 0.05 * self.radius)
            parent = child
        down = -0.2 * self.radius if self.joints == 0 else 0.0
        along = self.reach / (ahead if self.joints > 1 else 1)
        _joint(robot, "tip_mount", "fixed", parent, "tip", np.array([along, 0.0, down]))
        ElementTree.SubElement(robot, "link", name="tip")


def _link(robot: ElementTree.Element, name: str, mass: float, size: float) -> ElementTree.Element:
    link = ElementTree.SubElement(robot, "link", name=name)
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "mass", value=str(mass))
    moment = mass * size**2
    ElementTree.SubElement(
        inertial, "inertia", ixx=str(moment), ixy="0", ixz="0", iyy=str(moment), iyz="0", izz=str(1.6 * moment)
    )
    return link


def _joint(
    robot: ElementTree.Element, name: str, kind: str, parent: str, child: str, place: np.ndarray, turned: str = "0 0 0"
) -> ElementTree.Element:
    joint = ElementTree.SubElement(robot, "joint", name=name, type=kind)
    ElementTree.SubElement(joint, "origin", xyz=" ".join(map(str, place.tolist())), rpy=turned)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=child)
    return joint


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
