r"""Contact of tip and leaf: unilateral with friction, or, while the tip grips, a ball tie where it touched; both compliant.

MuJoCo's soft constraint with a constant impedance d obeys :math:`R f = -b\,v - k\,r - a` with
:math:`R = \frac{1-d}{d}\hat A`, where r, v, a are deflection, its rate and its acceleration. With
:math:`k = K R,\ b = B R` and a small d the constraint is a spring K and a damper B in N/m and N s/m, beside a negligible
virtual mass 1/R.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.model import Model

IMPEDANCE = 0.05
"""d: small, so that spring and damper and not the engine's estimate of the mass decide."""
FRICTION_RATE = 400.0
"""Rate at which friction stops a slip [1/s]."""
FRICTION_IMPEDANCE_RATIO = 1e5
"""Hardness of friction against that of the normal direction: keeps a loaded tip from creeping."""
TIE = "grip"
"""Name of the tie."""
_TIP, _GRIP = (2000.0, 60.0), (5000.0, 100.0)
"""Stiffness and damping for the shipped vehicle: pushing, and gripping [N/m], [N s/m]."""
_RESOLVED = 0.75
"""Largest damping of the gripper, times mobility of what it holds and time step: what turns more easily would be thrown."""
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


def add_contact(spec: Any, mujoco: Any, model: Model, tip: Any, leaf: Any) -> None:
    """Tie or pair the tip's body with the leaf's; `calibrate` must follow after compiling."""
    spec.add_exclude(name="tip_leaf", bodyname1=tip.name, bodyname2=leaf.name)
    if model.scenario.contact.kind == "grip":
        spec.add_equality(
            name=TIE, type=mujoco.mjtEq.mjEQ_CONNECT, objtype=mujoco.mjtObj.mjOBJ_SITE, name1="tip", name2="contact"
        )
    friction = model.scenario.simulation.tip_friction
    for ball in tip.geoms:
        for face in leaf.geoms:
            pair = spec.add_pair(name=f"push {ball.name} {face.name}", geomname1=ball.name, geomname2=face.name)
            pair.condim = 3 if friction > 0.0 else 1
            pair.friction = [max(friction, 1e-5)] * 2 + [1e-5] * 3


def calibrate(mujoco: Any, engine_model: Any, tip_body: int, leaf_body: int, model: Model) -> None:
    """Give tie and pairs the compliance of a spring and a damper."""
    size = model.scale
    resolved = _RESOLVED / (_mobility(mujoco, engine_model, leaf_body) * engine_model.opt.timestep)
    grip = _GRIP[0] * size.stiffness, min(_GRIP[1] * size.damping, resolved)
    tip = _TIP[0] * size.stiffness, _TIP[1] * size.damping
    inverse_mass = engine_model.body_invweight0[tip_body, 0] + engine_model.body_invweight0[leaf_body, 0]
    scale = -(1.0 - IMPEDANCE) * inverse_mass
    impedance = np.array([IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0])
    engine_model.eq_solref[:] = scale * grip[0], scale * grip[1]
    engine_model.eq_solimp[:] = impedance
    engine_model.pair_solref[:] = scale * tip[0], scale * tip[1]
    engine_model.pair_solimp[:] = impedance
    engine_model.pair_solreffriction[:] = -1.0, -FRICTION_RATE * IMPEDANCE  # the engine divides by the impedance


def _mobility(mujoco: Any, engine_model: Any, body: int) -> float:
    """Acceleration of the contact by a force of 1 N along its way, if it moves on the nearest joint alone [1/kg]."""
    place, turned = np.array(engine_model.site("contact").pos), np.zeros(9)
    while engine_model.body_jntadr[body] < 0:  # a handle that is fixed to the leaf
        mujoco.mju_quat2Mat(turned, engine_model.body_quat[body])
        place = engine_model.body_pos[body] + turned.reshape(3, 3) @ place
        body = int(engine_model.body_parentid[body])
    joint = int(engine_model.body_jntadr[body])
    arm = np.linalg.norm(np.cross(engine_model.jnt_axis[joint], place - engine_model.jnt_pos[joint]))
    slides = engine_model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
    return float(engine_model.dof_invweight0[engine_model.jnt_dofadr[joint]] * (1.0 if slides else arm**2))


class Gripper:
    """Ties the tip to the leaf where it touches, and lets it go."""

    def __init__(
        self,
        mujoco: Any,
        engine_model: Any,
        data: Any,
        tip_shapes: frozenset[int],
        leaf_shapes: frozenset[int],
        closes: bool = True,
        force: float | None = None,
    ) -> None:
        self._mujoco, self._model, self._data, self._closes = mujoco, engine_model, data, closes
        self._shapes = [(tip, leaf) for tip in tip_shapes for leaf in leaf_shapes]
        tie = mujoco.mj_name2id(engine_model, mujoco.mjtObj.mjOBJ_EQUALITY, TIE)
        self._tie = tie if tie >= 0 else None
        self._active = data.eq_active
        self._force = force
        self.slips = 0  # how often it was torn off the leaf
        self._slipped = False
        if self.closed and not closes:
            self._active[self._tie] = False
        self._model.pair_margin[:] = -_NO_CONTACT if self.closed else 0.0

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
            distance = min(
                self._mujoco.mj_geomDistance(self._model, self._data, tip, leaf, 1.0, None)
                for tip, leaf in self._shapes
            )
            if distance > _REACH:
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
        self._active[self._tie] = closed
        self._model.pair_margin[:] = -_NO_CONTACT if closed else 0.0


class ContactReader:
    """Reads the contacts of the last physics step out of MuJoCo."""

    def __init__(
        self,
        mujoco: Any,
        engine_model: Any,
        data: Any,
        tip_shapes: frozenset[int],
        leaf_shapes: frozenset[int],
        gripper: Gripper,
    ) -> None:
        self._mujoco, self._model, self._data, self._gripper = mujoco, engine_model, data, gripper
        self._signs = {(tip, leaf): 1.0 for tip in tip_shapes for leaf in leaf_shapes}
        self._signs |= {(leaf, tip): -1.0 for tip in tip_shapes for leaf in leaf_shapes}
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
