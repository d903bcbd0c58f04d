"""Rigid bodies of a vehicle, in numbers: its body with all that is fixed to it, and what each joint of the arm carries."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio

from doorman.arrays import Array, frozen

_CENTERED = 1e-4
"""Distance from O_B up to which a centre of mass counts as there [m]."""


@dataclass(frozen=True)
class Bodies:
    """Masses of the body (first) and of the arm's links, in body axes at H = 0."""

    masses: Array
    """Shape (n + 1,) [kg]."""
    centers: Array
    """Centres of mass from O_B (the body's) or from the link's joint, shape (n + 1, 3) [m]."""
    inertias: Array
    """About the centre of mass, shape (n + 1, 3, 3) [kg m²]."""

    @classmethod
    def of(cls, model: pinocchio.Model, data: pinocchio.Data) -> Bodies:
        """Bodies of a vehicle."""
        pinocchio.forwardKinematics(model, data, np.zeros(model.nq))
        bodies = [placement.act(each) for placement, each in zip(data.oMi, model.inertias, strict=True)]
        origins = [placement.translation for placement in data.oMi]
        return cls(
            frozen([body.mass for body in bodies]),
            frozen([body.lever - origin for body, origin in zip(bodies, origins, strict=True)]),
            frozen([body.inertia for body in bodies]),
        )

    @cached_property
    def balanced(self) -> bool:
        """Whether the centre of mass is O_B and the inertia the same in all postures: the arm has no mass (the paper's)."""
        massless = not self.masses[1:].any() and not self.inertias[1:].any()
        return massless and bool(np.linalg.norm(self.centers[0]) <= _CENTERED)

    def numbers(self) -> dict[str, Array]:
        """Masses, centres and inertias in SI units, by the names that a symbolic task knows them by."""
        upper = np.triu_indices(3)
        return {
            "bodies.masses": self.masses,
            "bodies.centers": self.centers.ravel(),
            "bodies.inertias": self.inertias[:, upper[0], upper[1]].ravel(),
        }
