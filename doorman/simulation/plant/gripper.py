"""Gripper, and the contacts of a physics step, as MuJoCo has them."""

from __future__ import annotations

import itertools
from typing import Any, NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.simulation.plant.contact import TIE
from doorman.simulation.plant.plant import Plant

_REACH = 0.02
"""Largest distance between tip and leaf at which the tip can grip [m]."""
_NO_CONTACT = 1e3
"""Depth that a contact must have to count while the tip grips [m]."""
TOUCH = 1e-6
"""Smallest force that counts as touching [N]."""


class ContactForces(NamedTuple):
    """Contacts of one physics step."""

    tip: Array  # force of the tip on the door, shape (3,), world frame [N]
    others: tuple[tuple[int, int], ...]  # pairs of shapes, by index, of all contacts but that of tip and leaf


NO_FORCES = ContactForces(np.zeros(3), ())
"""Where nothing touches anything; not to be written to."""


class Gripper:
    """Ties the tip to the leaf where it touches, and lets it go."""

    def __init__(self, mujoco: Any, plant: Plant, force: float | None) -> None:
        self._mujoco, self._plant, self._model, self._data = mujoco, plant, plant.engine_model, plant.data
        self._closes, self._force = force != 0.0, force  # whether it can, and what it holds at most [N]
        tie = mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_EQUALITY, TIE)
        self._tie = tie if tie >= 0 else None
        self._active = self._data.eq_active
        self.slips = 0  # how often it was torn off the leaf
        self._slipped = False
        self._tie_up(self.closed and self._closes)

    @property
    def closed(self) -> bool:
        """Whether the tip is tied to the leaf."""
        return self._tie is not None and bool(self._active[self._tie])

    def set(self, closed: bool) -> None:
        """Close or open; a gripper too far from the leaf closes on nothing, one that cannot close never does."""
        self._slipped &= closed
        if self._tie is None or closed == self.closed or (closed and (self._slipped or not self._closes)):
            return
        if closed:
            if self._plant.gap(self._mujoco) > _REACH:
                return
            tip, contact = self._data.site("tip"), self._model.site("contact")
            leaf = self._data.body(int(contact.bodyid[0]))
            contact.pos[:] = leaf.xmat.reshape(3, 3).T @ (tip.xpos - leaf.xpos)
        self._tie_up(closed)

    def strain(self, force: Array, normal: Array) -> None:
        """Tear the tip off where pull and force along the leaf exceed the grip; once per physics step."""
        if self._force is None or not self.closed:
            return
        held = force - max(float(normal @ force), 0.0) * normal
        if float(held @ held) > self._force**2:
            self._tie_up(False)
            self._slipped, self.slips = True, self.slips + 1

    def _tie_up(self, closed: bool) -> None:
        if self._tie is not None:
            self._active[self._tie] = closed
        self._model.pair_margin[:] = -_NO_CONTACT if closed else 0.0


class ContactReader:
    """Reads the contacts of the last physics step out of MuJoCo."""

    def __init__(self, mujoco: Any, plant: Plant, gripper: Gripper) -> None:
        self._mujoco, self._model, self._data, self._gripper = mujoco, plant.engine_model, plant.data, gripper
        self._signs = dict.fromkeys(itertools.product(plant.tip_shapes, plant.leaf_shapes), 1.0)
        self._signs |= dict.fromkeys(itertools.product(plant.leaf_shapes, plant.tip_shapes), -1.0)
        self._wrench = np.zeros(6)

    def read(self) -> ContactForces:
        """Force of the tip on the door, and the other contacts."""
        data = self._data
        count, closed = data.ncon, self._gripper.closed
        if not count and not closed:
            return NO_FORCES
        # the tie's rows come first; they hold the force on its first site, the tip
        tip = -data.efc_force[:3] if closed else np.zeros(3)
        others = []
        for index in range(count):
            contact = data.contact[index]
            shapes = (int(contact.geom1), int(contact.geom2))
            if contact.exclude:
                continue
            sign = self._signs.get(shapes)
            if sign is None:
                others.append(shapes)
                continue
            self._mujoco.mj_contactForce(self._model, data, index, self._wrench)
            tip += sign * (self._wrench[:3] @ contact.frame.reshape(3, 3))  # on the second shape, in the contact's axes
        return ContactForces(tip, tuple(others))
