r"""From what is known at the leaf to the start of a whole-body plan, and from the plan to commands.

What is known now is where the contact's spring makes the estimated force: :math:`P + (\delta(\hat\lambda) - \delta)\,n_D`, as a
millimetre of noise would be newtons. A plan begins where the inputs that were sent, and have not acted yet, take the vehicle from
there within the dead time of the attitude loop. It is followed by its inputs, at the time at which they are sent.
"""

from __future__ import annotations

import itertools
import math
from collections import deque
from typing import Any

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate
from doorman.control.kernels.tilted import tilted
from doorman.control.observers.tilt_observer import TiltObserver
from doorman.control.position_controller import Setpoint
from doorman.control.wanted import Wanted
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.model import Model
from doorman.planning.hinge import Hinge
from doorman.planning.pace import Pace
from doorman.planning.plan import Plan
from doorman.planning.whole_body.contact import depth_of, stick_place, tip_on_face, turned_by, whole_body_state
from doorman.planning.whole_body.numbers import loop_numbers, whole_body_numbers
from doorman.planning.whole_body.references import LEAST_RESISTANCE, Leaf, references
from doorman.signals import Command

_FREE_AIR = -0.01
"""Depth of a tip that does not touch, at most, as a share of R_A."""
_LEAST_FORCE = 0.01
"""Least normal force of plans where the tip touches, as a share of the weight: below it the spring of a plan is
farther from the leaf than the tip is."""
_AHEAD = 0.06
"""The onboard loop turns the vehicle at the rate that the plan has so much later [s]."""
_MOST_TURN = 0.25
"""Largest lead of the commanded heading [rad]."""
_MOST_SLOWER = 0.4
"""Largest rate that the heading is behind plans by and that is added [rad/s]: rotors that hold against the contact are at their
limits there, and more would turn the vehicle on once the contact ends."""
_ARM_TIME = 0.1
"""Low-pass of the joint rates [s]: they differ from plan to plan by noise, which would rattle the tip until friction lets go."""
_SIDE_TIME = 0.05
"""Low-pass of the force to the side [s], as of rotors."""
_KEPT = 1024
"""Inputs that are kept: of half a second at the fastest controller."""
_ROUNDED = 1e-6
"""By which times of ticks may be off [s]."""
_YAW_RATE = 11
"""Its place in the state."""


class WholeBodyController:
    """Starts and references of plans, and commands."""

    def __init__(self, model: Model) -> None:
        self._model, self._pace = model, Pace.of(model)
        self._numbers = whole_body_numbers(model)
        self._free_air = _FREE_AIR * model.vehicle.radius
        self._least_force = model.contact.between(_LEAST_FORCE * model.vehicle.weight, -model.contact.pull)
        self._hinge = Hinge.of(model.door)
        self.opening_rate = 0.0
        """Asked for now [rad/s]."""
        self.waits: Setpoint | None = None
        """Nothing is waited with: the phase flies until the first plan is known."""
        self._way = model.travel.sense
        self._goal: float | None = None
        self._arm_rates, self._side = np.zeros(model.n_arm), np.zeros(2)
        self._slower = 0.0
        """By which the heading's rate has stayed behind plans: the contact turns the vehicle, too [rad/s]."""
        self._turned: tuple[Estimate | None, Array] = None, np.zeros(2)  # of the last `aim`
        self._load = np.zeros(2)
        self._tilt = TiltObserver(model.attitude_loop, model.scenario.control.max_tilt)
        self._is_prompt = np.ones(4 + model.n_arm + (2 if model.actuation.fully else 0), dtype=bool)
        self._is_prompt[1:4] = False
        """Whether each input acts at once: tilt and heading do not."""
        self._prompt = np.flatnonzero(self._is_prompt)
        self._sent: deque[tuple[float, Array]] = deque(maxlen=_KEPT)
        """Inputs of the model, as they were sent."""
        self._waiting: deque[tuple[float, Array]] = deque()
        """Thrust, joint rates and force to the side that are sent when the tilt they were planned with acts, and that time."""
        self._followed: Array | None = None
        """Input of the plan that is followed, until it is sent."""
        self._shaped: Array | None = None
        """Roll and pitch that a plan commands, shaped for a quick loop, shape (2,) [rad]."""
        self.fly_by(model.attitude_loop)
        tilted(0.0, 0.0, 0.0)  # compiles: nothing is in flight

    def fly_by(self, loop: AttitudeLoop) -> None:
        """Believe another attitude loop from now on."""
        self._loop, self._shaping = loop.planned(self._numbers.one("plan.time_step")), loop.shaping
        self._loop_numbers = loop_numbers(self._model, self._loop)
        self._dead_time = loop.dead_time
        """Dead time of the loop as it is, not as a plan resolves it [s]."""
        self._tilt.fly_by(self._loop)

    def carry(self, load: Array) -> None:
        """Go on making a force in the face, along leaf and hinge, shape (2,) [N]: it holds a lever that was turned."""
        self._load = load

    def forget(self, goal: float | None = None) -> None:
        """Begin anew, with door and arm at rest: to bring the leaf to the goal, or to another angle [rad]."""
        self._goal = goal
        self._way = self._model.travel.sense if goal is None else math.copysign(1.0, goal - self._model.goal_angle)
        self.opening_rate = 0.0
        self._arm_rates, self._side = np.zeros(self._model.n_arm), np.zeros(2)
        self._waiting.clear()
        self._slower = 0.0
        self._tilt.forget()
        self._shaped = None

    def aim(self, known: Estimate, now: float, time_step: float) -> None:
        """Let the reference rate grow in contact, and fall to the door's where the tip has lost it.

        What turns the vehicle beside its commands is watched meanwhile.
        """
        opening, pace = self._way * known.door_rate, self._pace
        if known.touching:
            self.opening_rate = min(max(self.opening_rate, opening) + pace.acceleration * time_step, pace.rate)
        elif opening < self.opening_rate:
            self.opening_rate = max(opening, 0.0)
        self._turned = known, self._turned_by(known)
        self._tilt.update(known.attitude[:2], self._acting(known, now), self._turned[1], time_step)

    def note(self, now: float, command: Command, measured_yaw: float) -> None:
        """Take in what is sent now, by a plan or not, as an input of the model."""
        (roll, pitch, yaw), followed = command.attitude.tolist(), self._followed
        roll, pitch = tilted(roll, pitch, measured_yaw - yaw)
        if followed is not None and self._shaping > 0.0:
            roll, pitch = float(followed[1]), float(followed[2])  # what is sent is shaped, as the model's loop is not
        inputs = np.zeros(len(self._is_prompt))
        inputs[:3], inputs[3] = (command.thrust, roll, pitch), 0.0 if followed is None else followed[3]
        inputs[4 : 4 + self._model.n_arm] = command.arm_rates
        if self._model.actuation.fully:
            inputs[-2:] = command.side_force
        self._sent.append((now, inputs))
        self._followed = None

    def under_way(self, now: float) -> list[Array]:
        """Inputs that act before those of a plan that is made now, each the mean over one step of it, oldest first."""
        step, dead = self._numbers.one("plan.time_step"), self._loop.dead_time
        if not self._sent:
            return []
        first = self._acting_at(now - dead + _ROUNDED)
        sent, waiting, inputs = itertools.islice(self._sent, first, None), iter(self._waiting), list[Array]()
        acting, next_tilt, next_prompt = next(sent)[1].copy(), next(sent, None), next(waiting, None)
        acting[self._prompt] = self._sent[-1][1][self._prompt]
        time = now
        for end in (now + step * np.arange(1, 1 + round(dead / step))).tolist():
            inputs.append(np.zeros_like(acting))
            while time < end - _ROUNDED:
                while next_tilt is not None and next_tilt[0] + dead <= time + _ROUNDED:
                    acting[1:4], next_tilt = next_tilt[1][1:4], next(sent, None)
                while next_prompt is not None and next_prompt[0] <= time + _ROUNDED:
                    acting[self._prompt], next_prompt = next_prompt[1], next(waiting, None)
                until = min(end, next_tilt[0] + dead if next_tilt else end, next_prompt[0] if next_prompt else end)
                inputs[-1] += (until - time) / step * acting
                time = until
        return inputs

    def _acting(self, known: Estimate, now: float) -> Array:
        """Roll and pitch that are commanded by what acts now, shape (2,) [rad]; the measured ones before anything does."""
        time = now - self._dead_time + _ROUNDED
        if not self._sent or self._sent[0][0] > time:
            return known.attitude[:2]
        return self._sent[self._acting_at(time)][1][1:3]

    def _acting_at(self, time: float) -> int:
        """Place of the newest input that was sent by a time, or of the oldest."""
        place = len(self._sent) - 1
        while place > 0 and self._sent[place][0] > time:
            place -= 1
        return place

    def wanted(self, known: Estimate, now: float) -> Wanted:
        """A plan from now on."""
        state, numbers = self.start(known)
        return Wanted(state, self._hinge, numbers, self._goal, under_way=self.under_way(now))

    def start(self, known: Estimate) -> tuple[Array, dict[str, Any]]:
        """What a plan begins with, and aims for; what a held tip bears in the face acts on the vehicle as wind does."""
        model, numbers, angle = self._model, self._numbers, known.door_angle
        turned = self._turned[1] if self._turned[0] is known else self._turned_by(known)
        load = self._load[0] * known.along + self._load[1] * model.door.up
        depth, place = tip_on_face(known.tip - known.contact_point, known.normal, known.along, model.door.up)
        depth += known.face_offset
        touches = known.touching or model.contact.tied > 0.0
        force = max(known.normal_force, self._least_force)
        wanted = depth_of(force, numbers) if touches else min(depth, self._free_air)
        state = whole_body_state(
            known.position + (wanted - depth) * known.normal, known.attitude, known.velocity,
            known.attitude_rates, angle, known.door_rate, known.arm_angles,
        )  # fmt: skip
        if touches:
            place = stick_place(place, known.friction_force - self._load, force, numbers)
        held = np.zeros(2)
        if self._load.any():
            held = turned_by(model, known.rotation_body_to_world, known.arm_angles, load, self._loop)
        side = {"actuation.side": self._side} if model.actuation.fully else {}
        return state, {
            **side, **self._loop_numbers,
            **references(model, numbers, self._leaf(known, known.wind - load), self.opening_rate),
            "contact.stick": place, "contact.offset": numbers.one("contact.offset") + known.face_offset,
            "vehicle.wind": known.wind - load, "vehicle.tilt_offset": self._tilt.offset + held,
            "reference.turned": self._tilt.offset + turned,
        }  # fmt: skip

    def _leaf(self, known: Estimate, outer: Array) -> Leaf:
        """What is known of the leaf. Of the torque that resists, friction counts as it acts at this rate."""
        model, hinge, sense = self._model, known.hinge, self._model.travel.sense
        resistance = max(known.resistance, LEAST_RESISTANCE * model.hinge_scale)
        if model.contact.tied:  # which also draws a leaf on, and brakes what comes by itself
            rubs = hinge.friction * math.tanh(known.door_rate / self._numbers.one("door.friction_rate"))
            believed = Hinge(hinge.friction, sense * known.resistance - rubs, hinge.inertia, 0.0, 0.0)
        else:
            rubs = known.friction_share * resistance
            believed = Hinge(rubs, sense * (resistance - rubs), hinge.inertia, 0.0, 0.0)
        return Leaf(known.door_angle, known.door_rate, known.touching, believed, resistance, outer)

    def _turned_by(self, known: Estimate) -> Array:
        """Roll and pitch beside the command that the estimated force of the tip makes, shape (2,) [rad]."""
        if not known.touching:
            return np.zeros(2)
        return turned_by(self._model, known.rotation_body_to_world, known.arm_angles, known.tip_force, self._loop)

    def follow(
        self, plan: Plan, start: float, now: float, measured_yaw: float, yaw_rate: float, time_step: float
    ) -> Command:
        """What the vehicle is to do in a plan that started some time ago; after its end, what it does last.

        A heading, too, is followed when the dead time has passed, in which the vehicle turns on. Thrust, joints and the force
        to the side have no dead time: they wait for the tilt that they were planned with.
        """
        time, last = now - start, len(plan.inputs) - 1
        at = min(int(time / plan.time_step + 1e-6), last)
        later = min(int((time + _AHEAD) / plan.time_step), last)
        planned, gain = plan.inputs[at], self._model.scenario.control.yaw_gain
        slower = self._slower + gain * time_step * (float(plan.states[at, _YAW_RATE]) - yaw_rate)
        self._slower = min(max(slower, -_MOST_SLOWER), _MOST_SLOWER)
        turning = (plan.states[later + 1, _YAW_RATE] + self._slower) / gain
        lead = min(max(float(turning), -_MOST_TURN), _MOST_TURN)
        self._followed = planned
        roll, pitch = tilted(*self._shape(planned, time_step), lead)
        attitude = np.array((roll, pitch, lead + (measured_yaw + self._loop.dead_time * yaw_rate)))
        n, prompt = self._model.n_arm, self._at_its_time(planned[self._prompt], now)
        share = 1.0 - math.exp(-time_step / _ARM_TIME)
        self._arm_rates = self._arm_rates + share * (prompt[1 : 1 + n] - self._arm_rates)
        if not self._model.actuation.fully:
            return Command(float(prompt[0]), attitude, self._arm_rates.copy(), False)
        share = 1.0 - math.exp(-time_step / _SIDE_TIME)
        self._side = self._side + share * (prompt[-2:] - self._side)
        ahead, left = self._side
        return Command(float(prompt[0]), attitude, self._arm_rates.copy(), False, (float(ahead), float(left)))

    def _shape(self, planned: Array, time_step: float) -> tuple[float, float]:
        """Roll and pitch that a quick loop follows as the usual one does what is planned."""
        tilt = planned[1:3]
        if self._shaping > 0.0:
            last = self._shaped if self._shaped is not None else self._sent[-1][1][1:3] if self._sent else tilt
            tilt = last + (1.0 - math.exp(-time_step / self._shaping)) * (tilt - last)
        self._shaped = tilt
        return float(tilt[0]), float(tilt[1])

    def _at_its_time(self, planned: Array, now: float) -> Array:
        """Inputs that act at once, as planned together with the tilt that acts now."""
        waiting = self._waiting
        waiting.append((now + self._loop.dead_time, planned))
        if waiting[0][0] > now + _ROUNDED:  # nothing planned acts yet
            return self._sent[-1][1][self._prompt] if self._sent else planned
        while len(waiting) > 1 and waiting[1][0] <= now + _ROUNDED:
            waiting.popleft()
        return waiting[0][1]
