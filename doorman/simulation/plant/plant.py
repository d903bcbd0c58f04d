"""Plant: the compiled MuJoCo model of vehicle and door, its start, and where everything stands in its vectors."""

from __future__ import annotations

import copy
import itertools
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.exceptions import ScenarioError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.rotor_layout import RotorLayout
from doorman.model import Model
from doorman.simulation.plant.assembly import DOOR, VEHICLE, assemble, first_contact
from doorman.simulation.plant.contact import calibrate
from doorman.simulation.plant.faults import build_fault

Indices = NDArray[np.int64]

_MADE: WeakKeyDictionary[Model, dict[float, Any]] = WeakKeyDictionary()
"""Engine's models by time step: an environment that begins anew needs the same one again."""


@dataclass(frozen=True)
class Plant:
    """Compiled model with its addresses; `data` is the state that the physics advances."""

    engine_model: Any  # mjModel
    data: Any  # mjData
    root_to_base: Array  # homogeneous matrix of the base link in the free body, shape (4, 4)
    root_to_base_quaternion: Array  # its rotation as [w, x, y, z], shape (4,)
    base_body: int  # index of the base link
    arm_positions: Indices  # index of every arm joint in qpos, shape (n,)
    arm_velocities: Indices  # index of every arm joint in qvel, shape (n,)
    hinge_position: int  # index of the hinge in qpos
    hinge_velocity: int  # index of the hinge in qvel
    hinge: Door  # the door as it is
    tip_shapes: frozenset[int]  # geometry indices of the tip
    leaf_shapes: frozenset[int]  # geometry indices of the leaf
    leaf_body: int  # index of the leaf
    normal_in_leaf: Array  # n_D in the leaf's body, shape (3,)
    n_rotors: int  # number of rotors; their controls come first

    @property
    def door_angle(self) -> float:
        """α now [rad]."""
        return self.hinge.angle_of_joint(float(self.data.qpos[self.hinge_position]))

    @property
    def door_rate(self) -> float:
        """α̇ now [rad/s]."""
        return self.hinge.joint_rate(float(self.data.qvel[self.hinge_velocity]))

    def gap(self, mujoco: Any) -> float:
        """Distance of tip and leaf, negative where they overlap; at most 10 m [m]."""
        pairs = itertools.product(self.tip_shapes, self.leaf_shapes)
        return min(float(mujoco.mj_geomDistance(self.engine_model, self.data, *pair, 10.0, None)) for pair in pairs)

    def shape_name(self, index: int) -> str:
        """Name of a collision shape, without the prefix of vehicle or door."""
        return str(self.engine_model.geom(index).name).removeprefix(VEHICLE).removeprefix(DOOR)


def build_plant(mujoco: Any, model: Model, layout: RotorLayout, time_step: float) -> Plant:
    """Compile vehicle and door and put them at the start: at rest, tip at the contact point, rotors at hover thrust."""
    made = _MADE.setdefault(model, {})
    if time_step not in made:
        made[time_step] = _compiled(mujoco, model, layout, time_step)
    compiled = copy.copy(made[time_step])  # a flight writes to its own
    plant = _addresses(mujoco, compiled, model, layout.count)
    _place(mujoco, plant, model)
    hover = np.clip(layout.inverse @ hover_wrench(model), 0.0, layout.max_thrusts)  # rotors that hold the vehicle
    if compiled.na:
        plant.data.act[:] = hover
    plant.data.ctrl[: layout.count] = hover
    mujoco.mj_forward(compiled, plant.data)
    return plant


def _compiled(mujoco: Any, model: Model, layout: RotorLayout, time_step: float) -> Any:
    """Engine's model, as no flight has touched it."""
    spec = assemble(mujoco, model, layout, time_step)
    try:
        compiled = spec.compile()
    except ValueError as error:
        raise build_fault(model, error) from error
    tip, leaf = (int(compiled.site(name).bodyid[0]) for name in ("tip", "contact"))
    calibrate(mujoco, compiled, tip, leaf, model)
    return compiled


def _addresses(mujoco: Any, compiled: Any, model: Model, n_rotors: int) -> Plant:
    data = mujoco.MjData(compiled)
    data.qpos[:7] = [0, 0, 0, 1, 0, 0, 0]
    mujoco.mj_kinematics(compiled, data)
    base = int(compiled.site("base").bodyid[0])
    root_to_base = np.eye(4)
    root_to_base[:3, :3] = data.xmat[base].reshape(3, 3)
    root_to_base[:3, 3] = data.xpos[base]
    joints = [compiled.joint(VEHICLE + name) for name in model.vehicle.joint_names]
    hinge = compiled.joint(DOOR + model.true_door.section.hinge)
    bodies = {name: int(compiled.site(name).bodyid[0]) for name in ("tip", "contact")}
    shapes = {name: frozenset(np.flatnonzero(compiled.geom_bodyid == body).tolist()) for name, body in bodies.items()}
    normal = model.true_door.normal(model.true_door.angle_of_joint(float(data.qpos[hinge.qposadr[0]])))
    return Plant(
        engine_model=compiled,
        data=data,
        root_to_base=root_to_base,
        root_to_base_quaternion=np.array(data.xquat[base]),
        base_body=base,
        arm_positions=np.array([int(joint.qposadr[0]) for joint in joints], dtype=np.int64),
        arm_velocities=np.array([int(joint.dofadr[0]) for joint in joints], dtype=np.int64),
        hinge_position=int(hinge.qposadr[0]),
        hinge_velocity=int(hinge.dofadr[0]),
        hinge=model.true_door,
        tip_shapes=shapes["tip"],
        leaf_shapes=shapes["contact"],
        leaf_body=bodies["contact"],
        normal_in_leaf=np.array(data.xmat[bodies["contact"]].reshape(3, 3).T @ normal),
        n_rotors=n_rotors,
    )


def _place(mujoco: Any, plant: Plant, model: Model) -> None:
    """Set the start posture: the tip tied to the true leaf, its surface just touching it, or away from where it is believed."""
    state, n = model.start_state, model.n_arm
    data = plant.data
    motion = model.coupling.vehicle_motion(state, np.zeros(3), np.zeros(n))
    rotation = rotation_body_to_world(state[:3])
    inverse = np.linalg.inv(plant.root_to_base)
    to_face = first_contact(model) - model.coupling.contact_point(float(state[3]))
    data.qpos[:3] = motion.position + to_face + rotation @ inverse[:3, 3]
    mujoco.mju_mat2Quat(data.qpos[3:7], (rotation @ inverse[:3, :3]).ravel())
    data.qpos[plant.arm_positions] = state[5:]
    data.qpos[plant.hinge_position] = model.true_door.joint_value(_first_angle(model))
    hovers = model.scenario.mission.start == "hover"
    if model.scenario.contact.kind == "push" or hovers:
        true_normal = model.true_door.normal(float(state[3]))
        mujoco.mj_kinematics(plant.engine_model, data)
        data.qpos[:3] += plant.gap(mujoco) * true_normal
    if hovers:
        data.qpos[:3] += model.hover_offset - to_face


def _first_angle(model: Model) -> float:
    """α of the true leaf as the flight begins [rad]."""
    scenario, door, angle = model.scenario, model.true_door, model.start_angle
    ajar = scenario.simulation.door_ajar
    if ajar == 0.0:
        return angle
    if scenario.mission.start == "contact":
        raise ScenarioError(
            "a mission that starts in contact needs the leaf in its place", file=scenario.source, field="simulation.door_ajar",
            given=ajar, allowed="mission.start = \"hover\", or start.opening",
        )  # fmt: skip
    angle = door.angle_of_opening(door.opening_of(angle) + ajar)
    if door.lower_limit < door.upper_limit and not door.lower_limit <= angle <= door.upper_limit:
        least, most = sorted(door.opening_of(limit) for limit in (door.lower_limit, door.upper_limit))
        raise ScenarioError(
            "beyond the range of the hinge", file=scenario.source, field="simulation.door_ajar", given=ajar,
            allowed=f"a door that opens from {least:.3f} to {most:.3f} rad",
        )  # fmt: skip
    return angle


def hover_wrench(model: Model) -> Array:
    """Thrust and torques that hold the vehicle in its start posture: m g and c × f_t e₃ for its centre of mass c."""
    thrust = model.vehicle.weight
    center = model.vehicle.center_of_mass(model.start_arm)
    return np.array([thrust, *np.cross(center, [0.0, 0.0, thrust])])
