r"""Contact of tip and leaf: unilateral with friction, or, while the tip grips, a ball tie where it touched; both compliant.

MuJoCo's soft constraint with a constant impedance d obeys :math:`R f = -b\,v - k\,r - a` with
:math:`R = \frac{1-d}{d}\hat A`, where r, v, a are deflection, its rate and its acceleration. With
:math:`k = K R,\ b = B R` and a small d the constraint is a spring K and a damper B in N/m and N s/m, beside a negligible
virtual mass 1/R.
"""

from __future__ import annotations

from typing import Any

import numpy as np

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
