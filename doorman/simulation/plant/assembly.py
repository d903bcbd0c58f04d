"""Assembly: vehicle and door from their URDFs in one MuJoCo specification."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.collision.shapes import tip_link, tip_shapes
from doorman.exceptions import BackendError, ScenarioError
from doorman.gravity import weight_of
from doorman.kinematics.urdf.elements import link_name
from doorman.kinematics.urdf.structure import ROUNDING
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.model import Model
from doorman.simulation.plant.contact import FRICTION_IMPEDANCE_RATIO, add_contact
from doorman.simulation.plant.hulls import read_spec
from doorman.simulation.plant.onboard.servos import add_servos
from doorman.simulation.reality.beside import harden, set_beside, touched_link
from doorman.simulation.reality.true_vehicle import make_true, scale_mass

VEHICLE = "vehicle/"
DOOR = "door/"
ROOT = "flight"
"""Name of the free body and of its joint."""

_SMALLEST_MASS = 1e-6
_SMALLEST_INERTIA = 1e-10
"""MuJoCo refuses moving bodies without mass; the arm's links may be massless in the URDF [kg], [kg m²]."""
_VEHICLE_BIT, _DOOR_BIT = 1, 2
_TIP_RADIUS = 0.001
"""Ball given to a tip without collision shape [m]."""


def assemble(mujoco: Any, model: Model, layout: RotorLayout, time_step: float) -> Any:
    """Specification of the whole plant, ready to compile."""
    _check_first_contact(model)
    spec = mujoco.MjSpec()
    _set_options(spec, mujoco, time_step)
    door, section = read_spec(mujoco, model.true_door.urdf), model.scenario.door
    moving = (section.hinge, *(each.joint for each in section.beside))
    _prepare(mujoco, door, model.true_door.urdf, moving, _DOOR_BIT, _VEHICLE_BIT)
    tip_name, flown = tip_link(model.vehicle), model.vehicle
    vehicle = read_spec(mujoco, flown.urdf, tip_name, tip_shapes(flown))
    _prepare(mujoco, vehicle, flown.urdf, flown.joint_names, _VEHICLE_BIT, _VEHICLE_BIT | _DOOR_BIT)
    make_true(vehicle, vehicle.body(link_name(model.vehicle.urdf, model.vehicle.names.base_link)), model)
    root = spec.worldbody.add_body(name=ROOT, mass=_SMALLEST_MASS, inertia=[_SMALLEST_INERTIA] * 3)
    root.explicitinertial = True
    root.add_freejoint(name=ROOT)
    spec.attach(vehicle, prefix=VEHICLE, frame=root.add_frame())  # first: its free joint leads qpos and qvel
    turn = [math.cos(model.true_door.yaw / 2), 0, 0, math.sin(model.true_door.yaw / 2)]
    spec.attach(door, prefix=DOOR, frame=spec.worldbody.add_frame(pos=model.true_door.placement[:3, 3], quat=turn))
    base = spec.body(VEHICLE + link_name(model.vehicle.urdf, model.vehicle.names.base_link))
    tip = spec.body(VEHICLE + tip_name)
    leaf = spec.body(DOOR + touched_link(model))
    base.add_site(name="base")
    tip.add_site(name="tip")
    if not tip.geoms:
        tip.add_geom(name="tip", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[_TIP_RADIUS, 0, 0],
                     contype=_VEHICLE_BIT, conaffinity=_VEHICLE_BIT | _DOOR_BIT)  # fmt: skip
    placement = model.true_door.link_placements(model.start_angle)[touched_link(model)]
    leaf.add_site(name="contact", pos=placement[:3, :3].T @ (first_contact(model) - placement[:3, 3]))
    _set_hinge(spec, model)
    for each in section.beside:
        set_beside(spec.joint(DOOR + each.joint), each)
    _add_rotors(spec, mujoco, base, layout, model.scenario.simulation.motor_time_constant)
    add_servos(spec, mujoco, model.vehicle, VEHICLE)
    add_contact(spec, mujoco, model, tip, leaf)
    _count_contacts(spec, mujoco, tip, leaf)
    return spec


def _set_options(spec: Any, mujoco: Any, time_step: float) -> None:
    spec.compiler.degree = False
    spec.compiler.fusestatic = False
    option = spec.option
    option.timestep = time_step
    option.gravity = [0.0, 0.0, -weight_of(1.0)]
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = FRICTION_IMPEDANCE_RATIO
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # a diverging state must stay to be seen


def _count_contacts(spec: Any, mujoco: Any, tip: Any, leaf: Any) -> None:
    """The only sensors: numbers of all contacts, and of those of tip and leaf."""
    kind, body = mujoco.mjtSensor.mjSENS_CONTACT, mujoco.mjtObj.mjOBJ_BODY
    number = [1 << int(mujoco.mjtConDataField.mjCONDATA_FOUND), 0, 1]
    spec.add_sensor(name="contacts", type=kind, intprm=number)
    spec.add_sensor(
        name="tip on leaf", type=kind, objtype=body, objname=tip.name, reftype=body, refname=leaf.name, intprm=number
    )


def _prepare(mujoco: Any, part: Any, urdf: Path, moving: tuple[str, ...], kind: int, meets: int) -> None:
    """One URDF's specification for the plant: only the named joints move, every body has mass, every shape a name."""
    part.compiler.fusestatic = False  # would weld the root link into the world and lose its mass
    part.compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    part.compiler.boundmass, part.compiler.boundinertia = _SMALLEST_MASS, _SMALLEST_INERTIA
    for joint in list(part.joints):
        if joint.name not in moving:
            part.delete(joint)
    for body in part.bodies:
        _round_inertia(body, urdf)
        for index, shape in enumerate(body.geoms):
            shape.name = shape.name or f"{body.name}_{index}"
            shape.contype, shape.conaffinity = kind, meets


def _round_inertia(body: Any, urdf: Path) -> None:
    """Lift the principal moments A ≤ B ≤ C of a thin body, whose A + B = C may miss by a rounding error."""
    xx, yy, zz, xy, xz, yz = body.fullinertia
    if not np.isfinite([xx, yy, zz, xy, xz, yz]).all():
        return  # the URDF gives none
    smallest, middle, largest = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    missing = largest - smallest - middle
    if missing > ROUNDING * largest:
        raise BackendError(
            "the inertia of a link is not that of a rigid body", file=urdf, field=f"link {body.name}/inertial/inertia",
            given=[round(float(moment), 6) for moment in (smallest, middle, largest)],
            allowed="principal moments A, B, C with A + B >= C",
        )  # fmt: skip
    lift = max(missing, 0.0) + 1e-9 * largest
    body.fullinertia = [xx + lift, yy + lift, zz + lift, xy, xz, yz]


def first_contact(model: Model) -> Array:
    """Where the tip meets the true leaf at the start: the contact point, or what is before or behind it on the true face."""
    angle = model.start_angle
    return model.true_door.onto_face(model.coupling.contact_point(angle), angle)


def _check_first_contact(model: Model) -> None:
    """A flight that begins with the tip on the leaf needs a leaf there, where the true one stands elsewhere."""
    door, angle = model.true_door, model.start_angle
    if door is model.door or model.scenario.mission.start != "contact":
        return
    away = first_contact(model) - door.hinge_position
    along, up = float(door.leaf_direction(angle) @ away), float(door.up @ away)
    if not (0 <= along <= door.width and 0 <= up <= door.height):
        raise ScenarioError(
            "the tip would start beside the true leaf", file=model.scenario.source, field="simulation.door_offset",
            given=f"contact {along:.3f} m from the hinge, {up:.3f} m high",
            allowed=f"up to {door.width:g} m and {door.height:g} m, or mission.start = \"hover\"",
        )  # fmt: skip


def _set_hinge(spec: Any, model: Model) -> None:
    """The hinge's true torques and the leaf's true mass: the simulation's, else the ones that the planner counts on."""
    hinge, door, true = spec.joint(DOOR + model.true_door.section.hinge), model.true_door, model.scenario.simulation
    arm = door.per_angle
    hinge.damping[0] = door.damping / arm**2 if true.door_damping is None else true.door_damping
    hinge.frictionloss = door.friction / arm if true.door_friction is None else true.door_friction
    hinge.stiffness[0] = door.section.stiffness if true.door_stiffness is None else true.door_stiffness
    hinge.springref = door.joint_value(door.rest_angle if true.door_rest_angle is None else true.door_rest_angle)
    pressed_shut = (door.section.preload if true.door_preload is None else true.door_preload) > 0.0
    hinge.limited = pressed_shut or (door.lower_limit < door.upper_limit and not door.endless)
    if pressed_shut:  # no farther than closed
        hinge.range = sorted(door.joint_value(door.angle_of_opening(at)) for at in (0.0, door.largest_opening))
    harden(hinge)
    if true.door_mass is not None:
        scale_mass((hinge.parent, *hinge.parent.find_all("body")), true.door_mass / door.mass)


def _add_rotors(spec: Any, mujoco: Any, base: Any, layout: RotorLayout, time_constant: float) -> None:
    """One actuator a rotor; its control is a thrust set point [N], its activation the thrust after the motor's lag."""
    for index in range(layout.count):
        name = f"rotor_{index + 1}"
        base.add_site(name=name, pos=layout.positions[index], zaxis=layout.thrust_axes[index])
        actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_SITE)
        actuator.gear = [0.0, 0.0, 1.0, 0.0, 0.0, -layout.directions[index] * layout.torque_per_thrust]
        actuator.ctrllimited = True
        actuator.ctrlrange = [0.0, layout.max_thrusts[index]]
        if time_constant > 0.0:
            actuator.dyntype = mujoco.mjtDyn.mjDYN_FILTEREXACT
            actuator.dynprm[0] = time_constant
