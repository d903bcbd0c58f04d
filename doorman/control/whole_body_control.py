r"""From what is known at the leaf to the start of a whole-body plan, and from the plan to commands.

A plan begins where the contact's spring makes the estimated force: :math:`P + (\delta(\hat\lambda) - \delta)\,n_D`, as a
millimetre of noise would be newtons. It is followed by its inputs, at the time at which they act.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.control.estimation.leaf_estimator import LeafEstimate
from doorman.control.observers.tilt_observer import TiltObserver
from doorman.model import Model
from doorman.planning.plan import Plan
from doorman.planning.whole_body.contact import depth_of, stick_place, tip_on_face, turned_by, whole_body_state
from doorman.planning.whole_body.numbers import push_pace, whole_body_numbers
from doorman.planning.whole_body.references import at_the_leaf
from doorman.signals import Command

Array = NDArray[np.float64]

_FREE_AIR = -0.01
"""Depth of a tip that does not touch, at most, as a share of R_A."""
_LEAST_GRIP = 0.0034
"""Normal force that friction is told of at least, as a share of the weight."""
_AHEAD = 0.06
"""The onboard loop turns the vehicle at the rate that the plan has so much later [s]."""
_MOST_TURN = 0.25
"""Largest lead of the commanded heading [rad]."""
_ARM_TIME = 0.1
"""Low-pass of the joint rates [s]: they differ from plan to plan by noise, which would rattle the tip until friction lets go."""
_SIDE_TIME = 0.05
"""Low-pass of the force to the side [s], as of rotors."""
_YAW_RATE = 11
"""Its place in the state."""


class WholeBodyController:
    """Starts and references of plans, and commands.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        self._model, self._numbers = model, whole_body_numbers(model)
        self._ramp = push_pace(model).acceleration
        self._free_air = _FREE_AIR * model.vehicle.radius
        self._least_grip = _LEAST_GRIP * model.vehicle.weight
        self.opening_rate = 0.0
        """Asked for now [rad/s]."""
        self._arm_rates, self._side = np.zeros(model.n_arm), np.zeros(2)
        self._turned: tuple[LeafEstimate | None, Array] = None, np.zeros(2)  # of the last `aim`
        self._tilt = TiltObserver(model.attitude_loop, model.scenario.control.max_tilt)

    def forget(self) -> None:
        """Begin anew: door and arm stand."""
        self.opening_rate = 0.0
        self._arm_rates, self._side = np.zeros(self._model.n_arm), np.zeros(2)
        self._tilt.forget()

    def aim(self, known: LeafEstimate, time_step: float) -> None:
        """Let the opening rate that is asked for grow in contact, and fall to the door's where the tip has lost it.

        What turns the vehicle beside its commands is watched meanwhile.
        """
        opening, most = -known.door_rate, self._numbers.one("reference.opening_speed")
        if known.touching:
            self.opening_rate = min(max(self.opening_rate, opening) + self._ramp * time_step, most)
        elif opening < self.opening_rate:
            self.opening_rate = max(opening, 0.0)
        self._turned = known, self._turned_by(known)
        self._tilt.update(known.attitude[:2], self._turned[1], time_step)

    def start(self, known: LeafEstimate) -> tuple[Array, dict[str, Any]]:
        """What a plan begins with, and aims for."""
        numbers, angle = self._numbers, known.door_angle
        turned = self._turned[1] if self._turned[0] is known else self._turned_by(known)
        depth, place = tip_on_face(self._model, known.position, known.attitude, angle, known.arm_angles)
        depth += known.face_offset
        wanted = depth_of(known.normal_force, numbers) if known.touching else min(depth, self._free_air)
        state = whole_body_state(
            known.position + (wanted - depth) * self._model.door.normal(angle), known.attitude, known.velocity,
            known.attitude_rates, angle, known.door_rate, known.arm_angles,
        )  # fmt: skip
        if known.touching:
            place = stick_place(place, known.friction_force, max(known.normal_force, self._least_grip), numbers)
        weight = self._model.travel.ahead(self._model.door.weight_torque(angle))
        aims = at_the_leaf(
            numbers, known.lever, angle, known.touching, known.resistance, known.friction_share, known.inertia,
            self.opening_rate, -known.door_rate, weight,
        )  # fmt: skip
        offset = numbers.one("contact.offset") + known.face_offset
        side = {"actuation.side": self._side} if self._model.actuation.fully else {}
        return state, {
            **side,
            **aims, "contact.stick": place, "vehicle.wind": known.wind, "contact.offset": offset,
            "vehicle.tilt_offset": self._tilt.offset, "reference.turned": self._tilt.offset + turned,
        }  # fmt: skip

    def _turned_by(self, known: LeafEstimate) -> Array:
        """Roll and pitch beside the command that the estimated force of the tip makes, shape (2,) [rad]."""
        if not known.touching:
            return np.zeros(2)
        door, angle = self._model.door, known.door_angle
        along, up = door.face(angle)
        force = known.normal_force * door.normal(angle) + known.friction_force[0] * along + known.friction_force[1] * up
        return turned_by(self._model, known.attitude, known.arm_angles, force)

    def follow(self, plan: Plan, time: float, measured_yaw: float, time_step: float) -> Command:
        """What the vehicle is to do at a time of a plan; after its end, what it does last."""
        last = len(plan.inputs) - 1
        planned = plan.inputs[min(int(time / plan.time_step + 1e-6), last)]
        later = min(int((time + _AHEAD) / plan.time_step), last)
        turning = plan.states[later + 1, _YAW_RATE] / self._model.scenario.control.yaw_gain
        lead = min(max(float(turning), -_MOST_TURN), _MOST_TURN)
        self._tilt.tell(planned[1:3])
        attitude = tilted(planned[1], planned[2], lead)
        attitude[2] += measured_yaw
        share = 1.0 - math.exp(-time_step / _ARM_TIME)
        self._arm_rates = self._arm_rates + share * (planned[4 : 4 + self._model.n_arm] - self._arm_rates)
        if not self._model.actuation.fully:
            return Command(float(planned[0]), attitude, self._arm_rates.copy(), False)
        share = 1.0 - math.exp(-time_step / _SIDE_TIME)
        self._side = self._side + share * (planned[-2:] - self._side)
        ahead, left = self._side
        return Command(float(planned[0]), attitude, self._arm_rates.copy(), False, (float(ahead), float(left)))


def tilted(roll: float, pitch: float, yaw: float) -> Array:
    """Attitude with the thrust's direction of [roll, pitch, 0], and another heading."""
    up = np.array([math.sin(pitch) * math.cos(roll), -math.sin(roll), math.cos(pitch) * math.cos(roll)])
    c, s = math.cos(yaw), math.sin(yaw)
    ahead, aside = c * up[0] + s * up[1], -s * up[0] + c * up[1]
    return np.array([-math.asin(min(max(aside, -1.0), 1.0)), math.atan2(ahead, up[2]), yaw])
