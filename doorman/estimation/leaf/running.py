"""The bank at the leaf through a flight: one step for each pose, and a new beginning where it cannot go on."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from doorman.arrays import Array
from doorman.estimation.estimate import FilterEstimate
from doorman.estimation.filter import Filter
from doorman.estimation.leaf.constants import CONSTANTS
from doorman.estimation.leaf.hypotheses import FREE, HOLDING, STANDING, TOUCHING
from doorman.estimation.leaf.kernels.acting_step import Inputs
from doorman.estimation.leaf.kernels.report import LeafReport, LeafState
from doorman.estimation.leaf.leaf_filter import AT_THE_LEAF, AWAY, HELD, LEAF, leaf_filter
from doorman.estimation.leaf.numbers import LEAST_NOISE, PLACES, first_state
from doorman.estimation.leaf.swapped import Swapped
from doorman.estimation.status import Status
from doorman.kinematics.numbers import Numbers
from doorman.model import Model

_ENDED = (Status.LOST, Status.NOT_STARTED, Status.CLOCK)
"""After these the filter begins anew, where it was."""

Known = tuple[Array | float, Array | float]
"""Value and deviation of a state, or of each of its numbers."""
_OF_THE_LEAF = ("joint", "joint_rate", "resistance", "log_inertia", "face", "reach", "friction")


class LeafRun:
    """What is known of vehicle and leaf, from pose to pose; inputs are (m,) as `LeafMotion` has them."""

    def __init__(
        self, model: Model, numbers: Numbers, time: float, position: Array, inputs: Array, bank: Filter | None = None
    ) -> None:
        situation, first = _begins(model)
        self._model, self._met, self._settings = model, first != FREE, model.scenario.estimation
        self._known_face = model.ratios["length"] * CONSTANTS["start.face"][0]
        self._bank = bank or leaf_filter(model, numbers)
        self._situation, self._inputs, self._numbers = situation, inputs, numbers
        self._mean, self._doubt = first_state(model, numbers, position)
        mean, doubt = self._mean.floats, self._doubt.floats
        self._bank.start(time, mean, doubt, probabilities={first: 1.0}, inputs=inputs, situation=situation)
        self.estimate: FilterEstimate
        """At the last pose,"""
        self.report: LeafReport
        """and its parts by name."""
        self._look()
        self.time = time
        """Time of the last pose [s]."""
        self.status = Status.OK
        """Of the last step: `LOST` where it began anew,"""
        self.lost = False
        """and whether that was as no hypothesis had a meaning any more."""
        self._swapped = Swapped(model.scenario.safety.speed, self._settings.gate, self._settings.swap_time)
        self._seen_at = -math.inf
        self._taken, self._likelihood, self._fused, self._refused, self._innovation = time, 0.0, 0, 0, 0.0

    def _look(self) -> None:
        self.estimate = self._bank.estimate()
        self.report = LeafReport.of(self.estimate)

    def step(self, time: float, position: Array, inputs: Array, situation: str, felt: Array | None = None) -> Status:
        """Go on to a pose, (3,) [m], and what the tip feels, (1,) [N]; the status."""
        self.status = self._step(time, position, inputs, situation, felt)
        return self.status

    def _step(self, time: float, position: Array, inputs: Array, situation: str, felt: Array | None) -> Status:
        bank = self._bank
        if situation != self._situation:
            self._situation = situation
            bank.allow(situation)
        if not math.isfinite(sum(inputs.tolist())):
            return Status.NOT_FINITE
        bank.acted(0.5 * (self._inputs + inputs))
        self._inputs = inputs
        status = bank.measure("pose", time, position)
        if felt is not None:
            status = max(status, bank.measure("tip_force", time, felt))
        status = max(status, bank.step(time, inputs))
        if status < Status.REFUSED or time < self._taken:
            self._taken = time
        self.time, self.lost = time, status == Status.LOST
        if status in _ENDED or time - self._taken > self._settings.blow_time:
            self._begin_anew(time, position)
            status = max(status, Status.LOST)
        self._look()
        self._look_farther(situation)
        return status

    def unswapped(self, time: float, position: Array) -> tuple[Array, bool]:
        """A pose as the right markers would give it, shape (3,) [m], and whether the cameras see others; once for each pose."""
        state, passed = self.state, time - self.time
        expected = state.position + passed * state.velocity
        deviation = float(self._bank.parameters[self._numbers.place("sensor.pose")][0])
        seen = self._swapped.undone(time, position, expected, passed, deviation)
        return seen, self._swapped.now

    def see_leaf(self, time: float, joint: float, deviation: float) -> Status:
        """Take in where a sensor has seen the leaf, q [rad]; the next step fuses it at its own time, with the last deviation.

        Where the leaf stands before the first touch is only presumed: one that nothing touches is where it is seen.
        """
        off, number = abs(joint - self.state.joint), self._numbers.one
        far = off > self._settings.gate * math.hypot(deviation, self.deviations.joint)
        if far and self._touches() < 1.0 - self._settings.sure:
            rate = self.state.joint_rate, number("start.astray_rate")
            self._knows({"joint": (joint, deviation), "joint_rate": rate}, {FREE: 1.0})
        self._seen_at = time
        wanders = max(number("noise.face"), number("noise.face_by_angle") * self._doubt.face)
        self._set("noise.face", wanders)
        self._set("sensor.leaf", deviation)
        return self._bank.measure(LEAF, time, [joint])

    @property
    def state(self) -> LeafState:
        """Mean at the last pose."""
        return self.report.state

    @property
    def deviations(self) -> LeafState:
        """Standard deviations of the states at the last pose."""
        return self.report.deviations

    @property
    def log_likelihood(self) -> float:
        """Log-likelihood of all fused readings."""
        return self._likelihood + self._bank.log_likelihood

    @property
    def refused(self) -> int:
        """Poses beyond their gate."""
        return self._refused + self._bank.score("pose").refused

    @property
    def mean_nis(self) -> float:
        """Mean NIS of the poses."""
        score = self._bank.score("pose")
        total = self._innovation + (score.mean_nis * score.fused if score.fused else 0.0)
        return total / max(self._fused + score.fused, 1)

    def pose_deviation(self, deviation: float) -> None:
        """Say how noisy positions are [m]; from the next step on."""
        self._set("sensor.pose", max(deviation, LEAST_NOISE))

    def _set(self, name: str, value: Array | float) -> None:
        """Another value of a number of the bank."""
        self._bank.parameters[self._numbers.place(name)] = value

    def is_to_move(self, way: int) -> None:
        """Say whether a leaf that stands is to go on, 1, or back, -1: one that is held, 0, tells nothing of its friction."""
        more = self._numbers.one("contact.more")
        self._set("contact.more", more if way else -0.5 * more)
        self._set("contact.way", way or 1)

    def feels(self, normal: Array) -> None:
        """Say into which face the tip feels its way, unit vector, shape (3,); zeros if into none. No wind jumps just then."""
        self._set("frame.normal", normal)
        self._restart(self.estimate.mean, self.estimate.covariance, {FREE: 1.0})

    def leaves(self, is_to: bool) -> None:
        """Say whether the tip is to come off the leaf."""
        self._set("switch.lose", self._numbers.one("switch.leave" if is_to else "switch.lose"))
        self._set("switch.make", self._numbers.one("switch.follow" if is_to else "switch.make"))

    def know_face(self) -> None:
        """The face stands where it is believed: what is met elsewhere is a leaf that stands ajar."""
        self._doubt.face = min(self._doubt.face, self._known_face)
        self._knows({"face": (self.state.face, self._doubt.face)}, self.estimate.probabilities)

    def go_on(self, values: Mapping[str, Known]) -> None:
        """Begin with other means and deviations of some states, by name; the tip goes on bearing its force in the face."""
        self._set("contact.borne", values["friction"][0])
        self._knows(values, self.estimate.probabilities)

    def meet(self, joint: float | None, wind: Array | None = None) -> None:
        """Begin anew with the leaf somewhere else; where the mission begins, and with nothing learnt of it, if not given."""
        first, doubt = self._mean, self._doubt
        parts: dict[str, Known] = {name: (getattr(first, name), getattr(doubt, name)) for name in _OF_THE_LEAF}
        if joint is not None:  # no leaf goes beyond its joint's end
            stands = min(max(joint, self._model.door.lower_limit), self._model.door.upper_limit)
            off = self._model.coupling.lever_length * (joint - stands)
            parts["joint"] = stands, doubt.joint
            parts["face"] = first.face + off, doubt.face
        if wind is not None:
            parts["wind"] = wind, self.deviations.wind
        self._knows(parts)

    def _look_farther(self, situation: str) -> None:
        """A leaf that is not met where it should stand is beyond the tip; before the first touch, the map is right then."""
        touches = self._touches()
        self._met = self._met or touches > self._settings.sure
        # an unopened leaf rests: a tip that may be in thin air does not move it
        self._set("noise.drawn", self._numbers.one("noise.drawn") if self._met else 0.0)
        self._set("switch.stop", self._numbers.one("switch.stop") * (1.0 if self._met else touches))
        if situation != AT_THE_LEAF or touches > 1.0 - self._settings.sure:
            return
        coupling, state, seen = self._model.coupling, self.state, Inputs.of(self._inputs)
        posture, lever = (seen.attitude, seen.body_rates, seen.arm_angles, seen.arm_rates), coupling.lever_length
        tip, tip_rate = coupling.door_state(state.position, state.velocity, *posture)
        angle, joint, rate = tip - coupling.angle_of_face(state.face), state.joint, state.joint_rate
        doubt = math.hypot(lever * self.deviations.joint, self.deviations.face)
        if lever * (joint - angle) <= self._settings.elsewhere * doubt:
            return
        number = self._numbers.one
        if self.time - self._seen_at < self._settings.seen_time:  # the leaf is where it is seen: its face is elsewhere
            parts: dict[str, Known] = {"face": (lever * (tip - joint), self._known_face)}
        elif self._met:  # it flies ahead of the tip
            rate = min(rate, tip_rate)
            parts = {"joint": (angle, number("start.astray")), "joint_rate": (rate, number("start.astray_rate"))}
        else:
            still = 0.0, self._doubt.joint_rate
            parts = {"joint": (tip, number("start.astray")), "joint_rate": still, "face": (0.0, self._known_face)}
        self._knows(parts, {FREE: 1.0})

    def _touches(self) -> float:
        """Probability that the tip is at the leaf."""
        return self.estimate.probability_of(TOUCHING)

    def _knows(self, parts: Mapping[str, Known], probabilities: Mapping[str, float] | None = None) -> None:
        """Go on from the last pose with other values and deviations of some states, by name."""
        mean, covariance = self.estimate.mean.copy(), self.estimate.covariance.copy()
        for name, (value, deviation) in parts.items():
            place = PLACES[name]
            mean[place] = value
            covariance[place, :] = covariance[:, place] = 0.0
            np.fill_diagonal(covariance[place, place], np.square(deviation))
        self._restart(mean, covariance, probabilities)

    def _restart(self, mean: Array, covariance: Array, probabilities: Mapping[str, float] | None = None) -> None:
        """Go on from the last pose with another mean and covariance."""
        self._count()
        self._bank.start(
            self.estimate.time, mean, covariance, probabilities=probabilities, inputs=self._inputs,
            situation=self._situation,
        )  # fmt: skip
        self._look()

    def _count(self) -> None:
        score = self._bank.score("pose")
        self._likelihood += self._bank.log_likelihood
        self._fused, self._refused = self._fused + score.fused, self._refused + score.refused
        self._innovation += score.mean_nis * score.fused if score.fused else 0.0

    def _begin_anew(self, time: float, position: Array) -> None:
        """What was known of the leaf stays, as far as it is not known better than at the start."""
        known = self.estimate
        self._count()
        mean = LeafState.over(known.mean.copy())
        mean.velocity = np.zeros(3)
        if np.isfinite(position).all():
            mean.position = position
        doubt = LeafState.over(np.maximum(self._doubt.floats, known.deviations))
        fastest = self._model.scenario.safety.speed / 3.0  # three deviations
        doubt.velocity = np.maximum(doubt.velocity, fastest)
        self._bank.start(time, mean.floats, doubt.floats, inputs=self._inputs, situation=self._situation)
        self._taken = time


def _begins(model: Model) -> tuple[str, str]:
    """Situation, and the hypothesis that is true, as a mission begins."""
    if model.scenario.mission.start != "contact":
        return AWAY, FREE
    return (HELD, HOLDING) if model.scenario.contact.kind == "grip" else (AT_THE_LEAF, STANDING)
