"""What is known in flight: the bank of `doorman.estimation.leaf`, fed with measurements and commands, in the mission's words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

import numpy as np

from doorman.arrays import Array
from doorman.compilation import entry
from doorman.control.kernels.estimate_step import Carried, Carrying, ContactNumbers, LeafNow, carry_on
from doorman.control.kernels.tip import TipMotion
from doorman.estimation.leaf.acting import Acting
from doorman.estimation.leaf.hinge_fit import HingeEstimate, HingeFit
from doorman.estimation.leaf.hypotheses import RESTING, STOPPED, TOUCHING
from doorman.estimation.leaf.kernels.report import LeafOutputs, LeafReport, LeafState
from doorman.estimation.leaf.leaf_filter import (
    AT_THE_FRAME,
    AT_THE_LEAF,
    AWAY,
    CLOSING,
    HELD,
    leaf_filter,
)
from doorman.estimation.leaf.numbers import leaf_numbers
from doorman.estimation.leaf.running import Known, LeafRun
from doorman.kinematics.doors.leaf.leaf_kernels import leaf_numbers as door_numbers
from doorman.kinematics.rotations import SMALLEST_COSINE, euler_rates
from doorman.kinematics.vehicles.arms.arm import ArmParameters
from doorman.model import Model
from doorman.numba_types.handles import held
from doorman.one_line import OneLine
from doorman.position_noise import PositionNoise
from doorman.signals import Measurement
from doorman.stored_at_once import stored_at_once

_FIRST_NOISE = 1e-3
"""Noise of a pose's position, until it has been measured [m]."""
_LISTENS = 64
"""Poses after which the filter gets that noise again."""


class Tie(Enum):
    """What is known of tip and leaf."""

    FREE = "free"
    """The tip is away from the leaf."""
    PUSHING = "pushing"
    """It should press on the leaf; whether it does is estimated."""
    LEAVING = "leaving"
    """It should come off the leaf; one that shuts may meet it anywhere."""
    GRIPPED = "gripped"
    """It is tied to the leaf."""


@stored_at_once
@dataclass(frozen=True, eq=False, repr=False)
class Estimate(OneLine):
    """What is known at one time."""

    time: float
    """[s]."""
    position: Array
    """P, shape (3,), world frame [m]."""
    velocity: Array
    """Ṗ, shape (3,), world frame [m/s]."""
    arm_angles: Array
    """H, shape (n,) [rad]."""
    state: Array
    """Reduced, [Φ, α, α̇, H], yaw without jumps, shape (5 + n,)."""
    attitude_rates: Array
    """Φ̇, shape (3,) [rad/s]."""
    tip_angle: float
    """Angle of the tip about the hinge: α where it touches [rad]."""
    tip_speed: float
    """Speed of the tip along the door's normal, but for what tilting gives it: a law that fed that back would tilt the vehicle
    the other way, with the loop's dead time [m/s]."""
    wind: Array
    """On the vehicle, shape (3,), world frame [N]."""
    tip_force: Array
    """Force of the tip on the door, shape (3,), world frame [N]."""
    friction_force: Array
    """Its shares along the face and up, shape (2,) [N]."""
    normal_force: float
    """Its share along n_D: positive when the tip presses [N]."""
    near: bool
    """Whether the tip is where it may touch the leaf."""
    touching: bool
    """Whether it probably does."""
    resistance: float
    """Resistance of the joint against the way to the goal, beside the leaf's weight [N m],"""
    friction_share: float
    """of which this share does not drive it back."""
    face_offset: float
    """Offset of the face from where the model has it, towards the vehicle [m]."""
    door_disturbance: float
    """τ̂_d, all of the hinge's torque that the scenario does not name, in the sense of damping [N m]."""
    hinge: HingeEstimate
    normal: Array
    """n_D of the leaf where it is believed to be, shape (3,), world frame."""
    along: Array
    """c along that leaf, shape (3,), world frame."""
    contact_point: Array
    """Point of that leaf where the tip is to touch it, shape (3,), world frame [m]."""
    tip: Array
    """Shape (3,), world frame [m]."""
    rotation_body_to_world: Array
    """R(Φ), shape (3, 3)."""
    lift: float = 0.0
    """Lift of the rotors beyond their command, as a share of it."""
    stopped: bool = False
    """Whether a tip that feels for the frame is probably on it."""
    rests: bool = False
    """Whether the leaf at which the tip is probably rests."""
    angle_deviation: float = 0.0
    """Standard deviation of α [rad]."""
    lost: bool = False
    """Whether no hypothesis had a meaning any more, and the estimate began anew."""

    @property
    def attitude(self) -> Array:
        """Φ, yaw without jumps, shape (3,) [rad]."""
        return self.state[:3]

    @property
    def yaw(self) -> float:
        """ψ without jumps [rad]."""
        return float(self.state[2])

    @property
    def door_angle(self) -> float:
        """α [rad]."""
        return float(self.state[3])

    @property
    def door_rate(self) -> float:
        """α̇ [rad/s]."""
        return float(self.state[4])


_AT_THE_GOAL = 0.015
"""Nearer than this to the goal a leaf that stands is held [rad or m]."""
_REACH = 0.03
"""A tip that is farther from the leaf, beyond twice the deviation of where the leaf is, does not touch it [m]."""


class Estimator:
    """Estimates of one flight.

    Args:
        model: Model of the scenario.
        changes: Other values of `leaf_numbers`, by name.
    """

    def __init__(self, model: Model, changes: Mapping[str, float] | None = None) -> None:
        self._model, coupling = model, model.coupling
        self._rotors = np.array([0.0, 0.0, model.vehicle.weight])
        self._acting = Acting(model.n_arm, self._rotors, model.start_yaw)
        self._noise, self._poses = PositionNoise(), 0
        self._numbers = leaf_numbers(model, _FIRST_NOISE).replaced(changes or {})
        self._listens = "sensor.pose" not in (changes or {})
        self._bank = leaf_filter(model, self._numbers)  # compiles while nothing is in flight
        self.run: LeafRun | None = None
        """The bank, from the first pose on."""
        n, names = model.n_arm, self._bank.hypotheses
        self._measured = np.zeros(12 + 2 * n)
        self._state, self._found = np.zeros(5 + n), Carried()
        self._carrying = held(self._all(names))
        self._carry_on = entry(carry_on, self._carrying, LeafState(), LeafOutputs(), np.zeros(len(names)), 0.0)
        coupling.tips(np.zeros((1, 3)), np.zeros((1, n)))
        self._known: dict[str, Known] = {}
        self._face_is_known, self._leaf_time = False, -math.inf
        self._hinge = HingeFit(model)
        self._unnamed = 0.0
        self._sure, self._touches = model.scenario.estimation.sure, model.scenario.mission.start == "contact"
        self._rests = self._stopped = False
        self._feels: Array | None = None
        self._unloaded = np.zeros(2)  # sum of what the tip's sensor has read in free flight, and how many readings

    def _all(self, hypotheses: tuple[str, ...]) -> Carrying:
        """All that `carry_on` works on."""
        door, coupling, acting = self._model.door, self._model.coupling, self._acting
        contact = ContactNumbers(
            up=door.up, distance=coupling.distance_from_hinge, height=coupling.height, lever=coupling.lever_length
        )
        touching, resting, stopping = np.array(
            [[name in group for name in hypotheses] for group in _BELIEVED], dtype=float
        )
        state = self._state
        return Carrying(
            ArmParameters.of(self._model.vehicle.arm), door_numbers(door), contact, acting.ring, acting.tick, touching,
            resting, stopping, self._found, state[:3], LeafNow.over(state[3:5]), state[5:], TipMotion(), np.zeros(3),
        )  # fmt: skip

    @property
    def of_the_air(self) -> dict[str, Known]:
        """Wind and lift by name, with their deviations, as `go_on` takes them."""
        assert self.run is not None
        state, deviations = self.run.state, self.run.deviations
        return {"wind": (state.wind, deviations.wind), "lift": (state.lift, deviations.lift)}

    def go_on(self, tip_force: Array, of_the_air: Mapping[str, Known]) -> None:
        """Begin with what was known as another step ended: the tip's force, shape (3,) [N], and wind and lift."""
        door, numbers = self._model.door, self._numbers
        friction = np.array([door.leaf_direction(self._model.start_angle) @ tip_force, door.up @ tip_force])
        varies = numbers.one("contact.friction") * (
            float(np.linalg.norm(tip_force)) + numbers.one("contact.held") * self._model.vehicle.weight
        )
        self._known = {**of_the_air, "friction": (friction, np.full(2, varies))}

    def note_force(self, force: Array) -> None:
        """Take in the rotors' commanded force from now on, shape (3,), body frame [N]."""
        self._rotors = force

    def rates_are_late(self, lateness: float) -> None:
        """Take in how much later than the poses' attitudes the body rates come [s]."""
        self._acting.are_late(lateness)

    def update(self, measured: Measurement, tie: Tie, closes: bool, time_step: float) -> Estimate:
        """Take in one measurement; `closes` says whether the gripper is to be closed."""
        motion = measured.position, measured.velocity, measured.attitude, measured.body_rates
        parts = *motion, measured.arm_angles, measured.arm_rates
        np.concatenate(parts, out=self._measured)
        if not math.isfinite(sum(self._measured.tolist())):  # a sum of measurements does not overflow
            self._model.coupling.door_state(*parts)  # says what
        self._acting.note(measured, self._rotors)
        situation = {Tie.GRIPPED: HELD, Tie.FREE: AWAY}.get(tie, CLOSING if closes else AT_THE_LEAF)
        if situation == AWAY and self._feels is not None:
            situation = AT_THE_FRAME
        if self.run is None or measured.pose_time != self.run.time:
            self._take_pose(measured, situation, tie is Tie.LEAVING)
        assert self.run is not None
        return self._in_short(measured, self.run, time_step)

    def meet_leaf(self, tip_angle: float, wind: Array) -> None:
        """Learn that the tip touches the leaf where it is now, though that should be farther; its force passed for wind."""
        if self.run is not None:
            self.run.meet(tip_angle, wind)

    def feel(self, normal: Array | None) -> None:
        """Say into which face the tip feels its way, unit vector, shape (3,); None if into none."""
        changed, self._feels = normal is not self._feels, normal
        if self.run is not None and changed:
            self.run.feels(np.zeros(3) if normal is None else normal)

    def know_the_face(self) -> None:
        """The door stands where it is believed: a leaf that is met elsewhere stands ajar."""
        self._face_is_known = True
        if self.run is not None:
            self.run.know_face()

    def lose_leaf(self) -> None:
        """Forget the leaf and its hinge: it may be anywhere, and what was learnt when something went wrong may be wrong."""
        self._hinge = HingeFit(self._model)
        if self.run is not None:
            self.run.meet(None)

    def leaf_stays(self, angle: float) -> None:
        """The leaf has stood here with nothing at it."""
        self._hinge.stays(angle)

    def _take_pose(self, measured: Measurement, situation: str, leaves: bool) -> None:
        """One step of the bank."""
        self._poses += 1
        self._noise.note(self._poses, measured.position)
        position, attitude = measured.position, measured.attitude
        if self.run is not None:
            position, swapped = self.run.unswapped(measured.pose_time, position)
            attitude = self._acting.carried(measured.pose_time) if swapped else attitude
        inputs = self._acting.at(measured.pose_time, attitude)
        if self.run is None:
            self.run = LeafRun(self._model, self._numbers, measured.pose_time, position, inputs, self._bank)
            if self._known:
                # the leaf may have come along in the step before
                still, arm = np.zeros(3), measured.arm_angles
                angle, _ = self._model.coupling.door_state(
                    position, still, measured.attitude, still, arm, np.zeros(len(arm))
                )
                self.run.go_on(self._known | {"joint": (angle, self.run.deviations.joint)})
            if self._face_is_known:  # a sensor has seen the frame before the first pose
                self.run.know_face()
            return
        if (leaf := measured.leaf) is not None and leaf.time != self._leaf_time:
            self._leaf_time, door = leaf.time, self._model.door
            self.run.see_leaf(leaf.time, door.angle_of_joint(leaf.joint), leaf.deviation / door.per_angle)
        if self._listens and self._poses % _LISTENS == 0 and math.isfinite(noise := self._noise.deviation):
            self.run.pose_deviation(noise)
        self.run.leaves(leaves)
        left = self._model.travel.left(self.run.state.joint)
        self.run.is_to_move(int(left > _AT_THE_GOAL) - int(situation == HELD and left < -_AT_THE_GOAL))
        self.run.step(measured.pose_time, position, inputs, situation, self._felt(measured, situation))

    def _felt(self, measured: Measurement, situation: str) -> Array | None:
        """What the tip's sensor reads beyond what it reads in free flight, shape (1,) [N]."""
        if measured.tip_force is None:
            return None
        if situation == AWAY:
            self._unloaded += measured.tip_force, 1.0
        return np.array([measured.tip_force - self._unloaded[0] / max(float(self._unloaded[1]), 1.0)])

    def _in_short(self, measured: Measurement, run: LeafRun, time_step: float) -> Estimate:
        """What the bank knew at the last pose, carried on to now."""
        model, report, door = self._model, run.report, self._model.door
        found, state = self._carry(report, max(measured.time - run.estimate.time, 0.0))
        known, off, inertia = report.state, report.deviations.joint, math.exp(report.state.log_inertia)
        tip_angle, (angle, rate), resistance = found.tip_angle, state[3:5].tolist(), known.resistance
        if not math.isfinite(tip_angle + found.tip_speed):
            model.coupling.door_state(
                found.position, found.velocity, state[:3], found.attitude_rates, state[5:], measured.arm_rates
            )
        self._touches = touching = self._believes(found.touches, self._touches)
        self._rests = self._believes(found.rests, self._rests)
        self._stopped = self._believes(found.stopped, self._stopped)
        wind, doubt = found.wind, report.deviations
        if touching:
            strength = math.hypot(*wind[:2].tolist())
            self._hinge.learn(run.estimate.time, angle, rate, resistance, doubt.resistance, strength)
        unnamed = model.travel.sense * report.outputs.borne
        self._learn_unnamed(unnamed - door.damping * rate - door.stiffness * (angle - door.rest_angle), time_step)
        return Estimate(
            time=measured.time, position=found.position, velocity=found.velocity, arm_angles=state[5:], state=state,
            attitude_rates=found.attitude_rates, tip_angle=tip_angle, tip_speed=found.tip_speed, wind=wind,
            tip_force=found.tip_force, friction_force=found.friction, normal_force=found.normal_force,
            near=model.coupling.lever_length * (tip_angle - angle - 2.0 * off) < _REACH * model.scale.length,
            touching=touching, stopped=self._stopped, rests=self._rests, resistance=resistance,
            friction_share=self._hinge.friction_share(angle), face_offset=known.face, door_disturbance=self._unnamed,
            hinge=self._hinge.found(angle, inertia, inertia * doubt.log_inertia), normal=found.normal, along=found.along,
            contact_point=found.contact_point, tip=found.tip, rotation_body_to_world=found.rotation.reshape(3, 3),
            lift=known.lift, angle_deviation=off, lost=run.lost,
        )  # fmt: skip

    def _learn_unnamed(self, torque: float, time_step: float) -> None:
        """Follow the torque of the hinge that the scenario does not name [N m]."""
        control = self._model.scenario.control
        share = 1.0 - math.exp(-control.door_observer_rate * time_step)
        most = control.max_door_disturbance
        self._unnamed += share * (min(max(torque, -most), most) - self._unnamed)

    def _carry(self, report: LeafReport, age: float) -> tuple[Carried, Array]:
        """What is known of a pose, carried on by its age [s], as `estimate_step` has it, and the reduced state."""
        flat = self._carry_on(self._carrying, report.state, report.outputs, report.chances, age)
        found, state = self._found.snapshot(), self._state.copy()
        if abs(flat) < SMALLEST_COSINE:
            euler_rates(state[:3], self._measured[9:12])  # says what
        return found, state

    def _believes(self, chance: float, before: bool) -> bool:
        """Whether something is surely true, or was and is not surely false."""
        return chance > (1.0 - self._sure if before else self._sure)


_BELIEVED = TOUCHING, RESTING, (STOPPED,)
