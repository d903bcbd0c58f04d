"""Motion of the vehicle while its tip is at the leaf: force along the normal, the tip held where it is beside it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from doorman.arrays import Array
from doorman.control.doorway import DRIFTS, NO_GAP, Doorway
from doorman.control.estimation.estimator import Estimate
from doorman.control.motion import arm_rates_to
from doorman.control.position_controller import Setpoint
from doorman.kinematics.coupling import ROOM_TO_LEVEL
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model

SPEED_GAIN = 12.0
"""Gain of the tip's speed along the door's normal in free flight, for the shipped vehicle [N s/m]."""
LARGEST_PUSH = 2.0
"""Largest force of that law [N]."""
_CREEPS, _HASTES = 0.25, 2.0
"""Multiples of the touch's speed: of a resting tip that has left the leaf and comes back, and of one that looks for the leaf, or
draws back from it."""
_BLOCKED = 1.0
"""A tip that stands for so long before it is where the leaf should be has met it there [s];"""
_MOVES = 0.01
"""one that gets on, or is thrown back, by more does not stand [m]."""
_TURN = math.radians(2.0)
_MOST_TURNS = 20
"""Headings that are tried while the tip looks for the leaf."""
_ROOM = 0.02
"""Distance to leaf and jambs beyond the planner's margin then [m]."""
_NO_ROOM = 0.004
"""Gap between disc and jamb below which a vehicle leaves the doorway [m]."""
_WAY_OUT = 0.9
"""Speed with which a vehicle that gives way to a slammed door leaves the doorway [m/s];"""
_SHARE_OF_LIMIT = 0.8
"""of that, and of tilt, no more than this share of what the supervisor allows."""
_HARDEST, _LEAST_WAY = 4.0, 0.02
"""It brakes before a jamb by up to this [m/s²], within no less than this [m]."""


class AtTheLeaf:
    """Setpoints of the touch, of recovery and of the release."""

    def __init__(self, model: Model) -> None:
        self._model, self._coupling = model, model.coupling
        self._doorway = Doorway(model)
        self._room = model.scenario.planner.margin + _ROOM
        self._speed = model.scenario.mission.touch_speed
        self._speed_gain, self._most_push = SPEED_GAIN * model.scale.damping, LARGEST_PUSH * model.scale.force
        safety = model.scenario.safety
        self._steep = max(_SHARE_OF_LIMIT * safety.tilt, model.scenario.control.max_tilt)
        self._fastest = _SHARE_OF_LIMIT * safety.speed
        self._yaw = model.start_yaw
        self._offset = (0.0, 0.0)
        self._rest, self._still = np.zeros(3), np.zeros(model.n_arm)
        self._height = 0.0
        self._pressed = self._beside = 0.0
        self._moved_at: float | None = None
        self._stood = 0.0
        self.free_wind = np.zeros(3)
        """Outer force while the tip moved last, shape (3,), world frame [N]."""

    def begin(self, yaw: float, estimate: Estimate | None = None, pressed: float = 0.0) -> None:
        """Begin."""
        self._pressed, self._beside = pressed, 0.0
        self._yaw, self._moved_at = yaw, None
        self._height, self._offset = 0.0, (0.0, 0.0)
        if estimate is None:
            return
        along, upwards = self._model.door.level_first(estimate.along)
        off = estimate.tip - estimate.contact_point
        self._height, self._offset = float(estimate.position[2]), (float(along @ off), float(upwards @ off))
        if pressed > 0.0:
            most = self._model.scenario.contact.friction * pressed
            self._beside = min(max(float(along @ estimate.tip_force), -most), most)

    def contact_position(self, estimate: Estimate, yaw: float, arm: Array) -> Array:
        """Position of O_B, level, with the tip at the contact point of the door as it is now."""
        return self._coupling.vehicle_position(np.array((0.0, 0.0, yaw)), estimate.door_angle, arm)

    def push(self, estimate: Estimate, push: float) -> Setpoint:
        """Beside the normal, hold the tip where it is on the leaf; along it, push."""
        normal, rest = estimate.normal, self._rest
        yaw = self._yaw if self._pressed > 0.0 else estimate.yaw
        place = self.contact_position(estimate, yaw, estimate.arm_angles)
        aside, upwards = self._model.door.level_first(estimate.along)
        place = place + self._offset[0] * aside + self._offset[1] * upwards
        planned = place if self._offset == (0.0, 0.0) else estimate.position
        place = self._doorway.inside(place, planned, estimate.position, estimate.velocity)
        wind = float(normal @ estimate.wind)
        reaction = push * normal if estimate.touching else rest
        if estimate.touching and self._pressed > 0.0:
            reaction = reaction + min(max(push / self._pressed, 0.0), 1.0) * self._beside * aside
        return Setpoint(place, rest, rest, self._yaw, reaction, normal, self._still, push - wind)

    def draw_back(self, estimate: Estimate) -> Setpoint:
        """Draw the tip back along the normal, as far as that does not take the vehicle to a jamb."""
        door, push = self._model.door, self._toward(estimate, -_HASTES * self._speed)
        aside = push * float(estimate.normal @ door.along)
        return self.push(estimate, push * self._doorway.room(aside, estimate.position, estimate.velocity))

    def give_way(self, estimate: Estimate) -> Setpoint:
        """Go straight out before a leaf that shuts, and brake the way to the side that it gave the vehicle: to a jamb.

        Heading and arm keep step with the leaf, which is behind the tip.
        """
        position, rest, door = estimate.position, self._rest, self._model.door
        into, aside, _ = door.in_doorway(estimate.velocity)
        posture = self._model.on_the_way(estimate.tip_angle)
        place = self._doorway.inside(position, position, position, estimate.velocity)
        place[2], beyond = self._height, self._doorway.beyond(position)
        back = -math.copysign(math.sqrt(2.0 * _HARDEST * abs(beyond)), beyond)
        out = door.from_doorway(np.array([-min(max(-into, _WAY_OUT), self._fastest), back, 0.0]))
        way = max(self._doorway.room_beside(position, aside), _LEAST_WAY)
        brake = -math.copysign(min(aside * aside / (2.0 * way), _HARDEST), aside) * door.along
        rates = arm_rates_to(posture[5:], estimate.arm_angles)
        return Setpoint(place, out, brake, float(posture[2]), rest, rest, rates, max_tilt=self._steep)

    def rest(self, estimate: Estimate, push: float) -> Setpoint:
        """Push so gently that a small error of the force would take the tip away: that is braked, and the tip comes back."""
        return self.push(estimate, push + max(self._toward(estimate, _CREEPS * self._speed), 0.0))

    def move(self, estimate: Estimate, speed: float) -> Setpoint:
        """Move the tip along the normal."""
        return self.push(estimate, self._toward(estimate, speed))

    def _toward(self, estimate: Estimate, speed: float) -> float:
        """Push that gives the tip a speed along the normal [N]."""
        return min(max(self._speed_gain * (speed - estimate.tip_speed), -self._most_push), self._most_push)

    def search(self, estimate: Estimate) -> Setpoint:
        """Move the tip along the swing of a leaf that was not where it should be; heading and arm keep step with its angle.

        The heading stays behind by as much as keeps the disc clear of leaf and jambs, or as clear as can be.
        """
        posture = self._model.on_the_way(estimate.door_angle)
        back = math.copysign(_TURN, float(self._model.start_state[2] - posture[2]))
        widest = math.inf
        for _ in range(_MOST_TURNS):
            nearest = float(self._model.constraints(posture).max())
            if nearest < widest:
                widest, self._yaw = nearest, float(posture[2])
            if nearest < -self._room:
                break
            posture[2] += back
        return replace(
            self.move(estimate, _HASTES * self._speed), arm_rates=arm_rates_to(posture[5:], estimate.arm_angles)
        )

    def hits_the_rotors(self, estimate: Estimate) -> bool:
        """Whether the vehicle flies its rotor disc, and not its tip, into the leaf where that is believed to be."""
        now = self._gap(estimate, estimate.position, estimate.rotation_body_to_world[:, 2])
        return min(now, self._gap_soon(estimate)) < NO_GAP

    def _gap_soon(self, estimate: Estimate) -> float:
        """Gap after `DRIFTS`: the vehicle turns on about a tip that touches, or flies on, no farther than the tip lets it."""
        soon = estimate.attitude + DRIFTS * estimate.attitude_rates
        upwards = rotation_body_to_world(soon)[:, 2]
        if estimate.touching:
            now, then = self._coupling.tips(np.array([estimate.attitude, soon]), np.array([estimate.arm_angles] * 2))
            return self._gap(estimate, estimate.position + now - then, upwards)
        closing = float(estimate.normal @ estimate.velocity) + self._coupling.lever_length * estimate.door_rate
        before = float(estimate.normal @ (estimate.contact_point - estimate.tip)) - estimate.face_offset
        meets = before > -NO_GAP  # else it has passed the leaf's edge
        drift = min(DRIFTS * closing, max(before, 0.0)) if meets else DRIFTS * closing
        return self._gap(estimate, estimate.position, upwards) - drift

    def _gap(self, estimate: Estimate, position: Array, upwards: Array) -> float:
        """Between rotor disc and the leaf's face, of a vehicle that is there [m]."""
        gap = self._doorway.gap_to(position, upwards, estimate.contact_point, estimate.normal)
        return gap - estimate.face_offset

    def meets_a_jamb(self, estimate: Estimate) -> bool:
        """Whether the rotor disc is about to touch a jamb."""
        return self._doorway.gap_to_jambs(estimate.position, estimate.velocity) < _NO_ROOM

    def levels_into_a_jamb(self, estimate: Estimate) -> bool:
        """Whether the rotor disc would come too near to a jamb, were the vehicle to level as it lets go."""
        level = self.contact_position(estimate, estimate.yaw, estimate.arm_angles)
        return self._doorway.gap_to_jambs(level, self._rest) < ROOM_TO_LEVEL

    def blocked(self, estimate: Estimate) -> bool:
        """Whether the tip has been stopped before the place of the leaf, which has then come nearer; call it once per tick.

        A wind would not stop the tip for so long: it is estimated, and leaned into. A tip that comes on again after a slam has
        met nothing.
        """
        advance = float(estimate.normal @ estimate.position)
        if self._moved_at is None or abs(advance - self._stood) > _MOVES:
            self._stood, self._moved_at, self.free_wind = advance, estimate.time, estimate.wind.copy()
        return not estimate.near and estimate.time - self._moved_at >= _BLOCKED
