"""Findings about masses and inertias as the URDFs give them: what no rigid body has, and what no body of that size has."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from doorman.arrays import Array
from doorman.bounds import parse_numbers
from doorman.feasibility.report import Finding, found
from doorman.kinematics.urdf.elements import read_collisions
from doorman.kinematics.urdf.structure import ROUNDING, check_structure
from doorman.model import Model

_INERTIAL = {"value", "ixx", "iyy", "izz", "ixy", "ixz", "iyz"}
_DENSEST = 2.3e4
"""Density of osmium, the densest solid [kg/m³]."""


@dataclass(frozen=True)
class _Body:
    urdf: Path
    name: str
    mass: float  # [kg]
    moments: Array  # principal ones, ascending, shape (3,) [kg m²]
    size: float  # length within which all that its URDF describes fits [m]

    @property
    def where(self) -> str:
        return f"{self.urdf.name}: link {self.name}"

    @property
    def missing(self) -> float:
        """Share of C by which A + B ≥ C fails; negative where it holds."""
        smallest, middle, largest = self.moments
        return float((largest - smallest - middle) / largest) if largest > 0.0 else 0.0

    @property
    def excess(self) -> float:
        """Radius of gyration as a share of the size, or density as one of osmium's, whichever is larger: a body's is below 1."""
        largest = max(float(self.moments[2]), 0.0)
        if self.mass <= 0.0:
            return math.inf if largest > 0.0 else 0.0
        return max(math.sqrt(largest / self.mass) / self.size, self.mass / (_DENSEST * self.size**3))


def body_findings(model: Model) -> list[Finding]:
    """Whether masses and inertias of both URDFs can be those of rigid bodies."""
    vehicle, door = model.vehicle, model.true_door
    bodies = [*_bodies(vehicle.urdf, 2.0 * vehicle.radius), *_bodies(door.urdf, door.width + door.height)]
    return [_rigid(bodies), _magnitudes(bodies)]


def _rigid(bodies: list[_Body]) -> Finding:
    r"""Principal moments of a rigid body are not negative, and fulfil :math:`A + B \ge C`."""
    worst = max(bodies, key=lambda body: body.missing if body.moments[0] >= 0.0 else math.inf)
    smallest, middle, largest = worst.moments
    ok = smallest >= 0.0 and worst.missing <= ROUNDING
    words = f"principal moments {smallest:.4g}, {middle:.4g} and {largest:.4g} kg m²"
    fault = "one is negative" if smallest < 0.0 else "in a rigid body none is larger than the sum of the other two"
    message = (
        f"all {len(bodies)} links with mass can be rigid bodies; nearest to the limit is {worst.name}, with {words}"
    )
    return found(
        "inertias", ok, message if ok else f"{worst.where}/inertial/inertia has {words}: {fault}", worst.missing, ROUNDING, "",
        "give moments about the link's centre of mass with A + B >= C, such as those of a box of its size",
    )  # fmt: skip


def _magnitudes(bodies: list[_Body]) -> Finding:
    """No body's radius of gyration is larger than what its URDF describes, and none is denser than osmium."""
    worst = max(bodies, key=lambda body: body.excess)
    ok = worst.excess <= 1.0
    message = (
        f"{worst.where} has {worst.mass:.4g} kg and {worst.moments[2]:.4g} kg m², and all shapes of its URDF fit into "
        f"{worst.size:.2f} m"
    )
    return found(
        "magnitudes", ok, message if ok else f"{message}: no body of that size has such values", worst.excess, 1.0, "",
        "check the units: mass in kg, inertia in kg m², lengths in m",
    )  # fmt: skip


def _bodies(urdf: Path, least: float) -> Iterator[_Body]:
    size = max(_reach(urdf), least)
    for link in check_structure(urdf).findall("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        parts = (inertial.find(tag) for tag in ("mass", "inertia"))
        values = {
            key: float(part.get(key, "0")) for part in parts if part is not None for key in _INERTIAL & {*part.keys()}
        }
        xx, yy, zz, xy, xz, yz = (values[key] for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"))
        moments = np.asarray(np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), dtype=np.float64)
        yield _Body(urdf, link.get("name", ""), values["value"], moments, size)


def _reach(urdf: Path) -> float:
    """Length of all joints' offsets and primitive shapes laid end to end: nothing reaches farther [m]."""
    shapes = [shape for shape in read_collisions(urdf) if shape.kind != "mesh"]
    reach = sum(float(np.linalg.norm(shape.size) + np.linalg.norm(shape.placement[:3, 3])) for shape in shapes)
    return reach + sum(_offset(joint) for joint in check_structure(urdf).findall("joint"))


def _offset(element: ElementTree.Element) -> float:
    origin = element.find("origin")
    return 0.0 if origin is None else float(np.linalg.norm(parse_numbers(origin.get("xyz", "0 0 0"))))
