"""Vehicle: the arm's kinematics, masses, limits and rotors, all from its URDF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import ArrayLike

from doorman.arrays import Array, frozen
from doorman.checks import vector
from doorman.copying import PerThread
from doorman.exceptions import UrdfError
from doorman.gravity import weight_of
from doorman.kinematics.urdf.robot import (
    frame_index,
    joint_placements_along,
    link_index,
    links_of,
    load_pinocchio,
    with_standing,
)
from doorman.kinematics.vehicles.arms.arm_joints import arm_chain, check_followers, joint_limits, standing_joints
from doorman.kinematics.vehicles.arms.arm_pattern import ArmGeometry
from doorman.kinematics.vehicles.bodies import Bodies
from doorman.kinematics.vehicles.disc import disc_radius, propeller_reach
from doorman.kinematics.vehicles.rotors import Rotor, read_rotors
from doorman.scenario import VehicleSection

__all__ = ["ArmGeometry", "Rotor", "Vehicle"]


_LEVEL = 1e-3
"""Height above the rotors up to which an arm's first joint, or the tip of a stick, counts as level with them [m]."""
_WEIGHTLESS = 0.01
"""Share of the whole mass up to which what carries the base link only writes that it moves, and is no cart and no rail."""


class Vehicle:
    """Flying vehicle with an arm of n joints from `base_link` to `tip`: revolute, continuous or prismatic; none of a fixed stick.

    Angles, rates and torques of a prismatic joint are lengths, speeds and forces [m, m/s, N]. All positions are in the body frame
    of the base link: x forward, y left, z up. Threads may share it.
    """

    def __init__(self, urdf: Path, names: VehicleSection | None = None) -> None:
        self.urdf = urdf
        self.names = names or VehicleSection()
        self.standing_joints: tuple[str, ...] = ()
        """Joints that could move, are neither of the arm nor rotors, and stand at zero."""
        full = self._on_virtual_joints(load_pinocchio(urdf, endless=False))
        self.model, self.joint_names = self._arm_only(full)
        self._own: PerThread[pinocchio.Data] = PerThread()
        self._stand_on_base_link()
        self._tip_frame = frame_index(self.model, self.names.tip, urdf, "vehicle.tip")
        self.links = links_of(self.model)
        self._point_frames = [*self._servo_frames(), self._tip_frame]
        self.point_names = tuple(self.model.frames[i].name for i in self._point_frames)
        self.mass = self._positive_mass()
        self.bodies = Bodies.of(self.model, self._data)
        limits = joint_limits(urdf, self.model, self.joint_names)
        self.slides, self.lower_limits, self.upper_limits, self.rate_limits, self.torque_limits = limits
        self.rotors = read_rotors(urdf, self.model, self.names.rotors.assume)
        self.radius = float(self.names.radius or disc_radius(urdf, self.model))
        self.max_thrust = self._thrust_limit()
        self.arm = self._arm_geometry()

    @property
    def _data(self) -> pinocchio.Data:
        return self._own.get(self.model.createData)

    @property
    def weight(self) -> float:
        """Weight of vehicle and arm, m_A g [N]."""
        return weight_of(self.mass)

    @property
    def propeller_reach(self) -> float:
        """Largest distance of a propeller's tip from the body's z axis, as far as the URDF shows propellers; else zero [m]."""
        return propeller_reach(self.urdf, self.model)

    @property
    def angle_units(self) -> tuple[str, ...]:
        """Unit of every joint's position, shape (n,)."""
        return tuple("m" if slides else "rad" for slides in self.slides)

    @property
    def n_arm(self) -> int:
        """Number of the arm's joints, n."""
        return int(self.model.nq)

    def inertia(self, arm_angles: ArrayLike) -> Array:
        """Rotational inertia I_A of vehicle and arm about O_B for a given posture."""
        return np.array(self._together(arm_angles).matrix()[3:, 3:])

    def center_of_mass(self, arm_angles: ArrayLike) -> Array:
        """Centre of mass c of vehicle and arm, in the body frame."""
        return np.array(self._together(arm_angles).lever)

    def _together(self, arm_angles: ArrayLike) -> pinocchio.Inertia:
        """Mass, centre of mass and inertia of all bodies, in the body frame."""
        pinocchio.forwardKinematics(self.model, self._data, vector(arm_angles, self.n_arm, "arm_angles"))
        placed = zip(self.model.inertias, self._data.oMi, strict=True)
        return sum((placement.act(body) for body, placement in placed), pinocchio.Inertia.Zero())

    def center_of_mass_jacobian(self, arm_angles: ArrayLike) -> Array:
        r"""Jacobian :math:`\partial c/\partial H` of `center_of_mass`."""
        angles = vector(arm_angles, self.n_arm, "arm_angles")
        if self.bodies.masses[1:].sum() == 0.0:  # Pinocchio would divide by that mass
            return np.zeros((3, self.n_arm))
        jacobian = pinocchio.jacobianCenterOfMass(self.model, self._data, angles)  # of what joints carry alone
        share = self._data.mass[0] / self.mass
        return np.asarray(share * jacobian).reshape(3, self.n_arm)  # Pinocchio gives a vector for one joint

    def tip_position(self, arm_angles: ArrayLike) -> Array:
        """Position d of the tip in the body frame."""
        tip: Array = self.point_positions(arm_angles)[-1]
        return tip

    def tip_jacobian(self, arm_angles: ArrayLike) -> Array:
        r"""Jacobian :math:`J_d = \partial d/\partial H`."""
        jacobian: Array = self.point_jacobians(arm_angles)[-1]
        return jacobian

    def point_positions(self, arm_angles: ArrayLike) -> Array:
        """Positions of S³ … Sⁿ and the tip in the body frame."""
        pinocchio.framesForwardKinematics(self.model, self._data, vector(arm_angles, self.n_arm, "arm_angles"))
        return np.array([self._data.oMf[i].translation for i in self._point_frames])

    def point_jacobians(self, arm_angles: ArrayLike) -> Array:
        """Jacobians of `point_positions` with respect to H."""
        angles = vector(arm_angles, self.n_arm, "arm_angles")
        if not self.n_arm:  # Pinocchio would end the process
            return np.zeros((len(self._point_frames), 3, 0))
        pinocchio.computeJointJacobians(self.model, self._data, angles)
        pinocchio.updateFramePlacements(self.model, self._data)
        world = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobians = [pinocchio.getFrameJacobian(self.model, self._data, i, world) for i in self._point_frames]
        shape = (6, self.n_arm)  # a single column arrives as a flat array
        return np.array([np.reshape(jacobian, shape)[:3] for jacobian in jacobians])

    def link_placements(self, arm_angles: ArrayLike) -> dict[str, Array]:
        """Placement of every link in the body frame."""
        joints = self.joint_placements_along(vector(arm_angles, self.n_arm, "arm_angles")[None])[0]
        return {name: joints[link.joint] @ link.placement for name, link in self.links.items()}

    def joint_placements_along(self, arm_angles: Array) -> Array:
        """Placements of what carries the `links`, in the body frame, at each of m postures."""
        return joint_placements_along(self.model, self._data, arm_angles)

    def _stand_on_base_link(self) -> None:
        """Put the origin of Pinocchio's model where the base link is, which is fixed to the tree's root."""
        model = self.model
        base = model.frames[link_index(model, self.names.base_link, self.urdf, "vehicle.base_link")].placement.inverse()
        model.inertias[0] = base.act(model.inertias[0])
        for joint in range(1, model.njoints):
            if model.parents[joint] == 0:
                model.jointPlacements[joint] = base * model.jointPlacements[joint]
        for frame in model.frames:
            if frame.parentJoint == 0:
                frame.placement = base * frame.placement

    def _on_virtual_joints(self, full: pinocchio.Model) -> pinocchio.Model:
        """With the joints at zero that carry the base link, and weigh nothing: a floating base may be written as six joints."""
        base = full.frames[link_index(full, self.names.base_link, self.urdf, "vehicle.base_link")].parentJoint
        beside = sum(body.mass for body, above in zip(full.inertias, full.supports, strict=True) if base not in above)
        virtual = base and beside <= _WEIGHTLESS * sum(body.mass for body in full.inertias)
        return with_standing(full, list(full.supports[base])[1:], pinocchio.neutral(full)) if virtual else full

    def _arm_only(self, full: pinocchio.Model) -> tuple[pinocchio.Model, tuple[str, ...]]:
        """Lock every joint that is not on the chain from the base link to the tip."""
        chain = arm_chain(full, self.names.base_link, self.names.tip, self.urdf)
        names = tuple(full.names[i] for i in chain)
        check_followers(self.urdf, set(names))
        self.standing_joints = standing_joints(full, self.names.base_link, names)
        others = [i for i in range(1, full.njoints) if i not in chain]
        return with_standing(full, others, pinocchio.neutral(full)), names

    def _servo_frames(self) -> list[int]:
        """Frames of joints 3 … n: `servo_k`, else the joint itself."""
        joints = enumerate(self.joint_names[2:], 3)
        known = [name if self.model.existFrame(name) else joint for k, joint in joints for name in (f"servo_{k}",)]
        return [self.model.getFrameId(name) for name in known]

    def _positive_mass(self) -> float:
        mass, where = (
            float(sum(inertia.mass for inertia in self.model.inertias)),
            f"link {self.names.base_link}/inertial",
        )
        if not mass > 0.0:
            raise UrdfError(
                "the vehicle has no mass", file=self.urdf, field=f"{where}/mass", given=mass, allowed="> 0 kg"
            )
        inertia = self.inertia(np.zeros(self.n_arm))
        if np.linalg.eigvalsh(inertia)[0] <= 0.0:
            raise UrdfError(
                "the vehicle's rotational inertia is not positive definite", file=self.urdf, field=f"{where}/inertia",
                given=np.diag(inertia).round(9).tolist(), allowed="> 0 kg m² about every axis",
            )  # fmt: skip
        return mass

    def _thrust_limit(self) -> float:
        if self.names.max_thrust is not None:
            return float(self.names.max_thrust)
        if self.rotors:
            return float(sum(rotor.max_thrust * rotor.axis[2] for rotor in self.rotors))
        return 2.0 * self.weight

    def _arm_geometry(self) -> ArmGeometry:
        pinocchio.framesForwardKinematics(self.model, self._data, np.zeros(self.n_arm))
        pinocchio.computeJointJacobians(self.model, self._data, np.zeros(self.n_arm))
        joints = np.array([placed.translation for placed in self._data.oMi][1:]).reshape(-1, 3)
        columns = np.reshape(self._data.J, (6, self.n_arm))  # a single column arrives as a flat array
        axes = np.where(self.slides, columns[:3], columns[3:]).T
        parents = np.array([self.model.frames[i].parentJoint - 1 for i in self._point_frames], dtype=np.int64)
        points = np.array([self._data.oMf[i].translation for i in self._point_frames])
        origins = np.vstack([joints, np.zeros(3)])  # index −1: the body
        parents.flags.writeable = False
        rotors = max([0.0, *(float(rotor.position[2]) for rotor in self.rotors)])  # the plane z = 0 without any
        return ArmGeometry(
            axes=frozen(axes),
            links=frozen(np.diff(np.vstack([np.zeros(3), joints]), axis=0)),
            slides=self.slides,
            point_parents=parents,
            point_offsets=frozen(points - origins[parents]),
            above=bool((joints if self.n_arm else points)[0][2] > rotors + _LEVEL),
        )
