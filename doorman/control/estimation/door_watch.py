"""Whether a sensor of the door is to be believed, judged by what the tip does; and where it says that the door stands.

A tip cannot go through a leaf. Let g be the tip's distance from the leaf as it is measured. In contact g is near a constant,
which holds what the map is off. A leaf that is measured ever farther on the vehicle's side of the tip is not there: the
readings stand still, come late, or are of something else. A tip that grips cannot leave the leaf either. Readings that jump by
more than a leaf can move are left out, and if they stay there, the source has lied.

A source that has lied is named in a message, and not believed again in this flight.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.estimator import Estimate, Tie
from doorman.model import Model
from doorman.signals import FrameReading, Measurement

_FASTEST = 3.0
"""Rate of the fastest leaf, slammed by wind [rad/s]."""
_SLOWER = 0.1
"""Share of that rate by which what has jumped may come back to where it was: time alone excuses no jump."""
_JUMPED = 0.2
"""Readings that stay where no leaf could have come to for so long are lies [s]."""
_UNLIKELY = 5.0
"""Deviations."""
_INSIDE = 0.012
"""By which the tip may seem to be in the leaf beyond what it was when they met: compliance, and a map that turns [m]."""
_LASTS = 0.1
"""For so long it must [s]."""
_RELAXES = 1.5
"""Time in which what is constant may change, as the map's error shows differently at every angle [s]."""
_TELLS = 3.0
"""Deviations of the map by which tip and measured leaf may be apart when they meet."""
_BEYOND = math.radians(2.0)
"""By which a leaf may seem to be beyond its stop: its mark was put on by eye [rad]."""
_APART = 0.02
"""By which they may be apart then beside that [m]."""


class DoorWatch:
    """Judge of one flight's sensor."""

    def __init__(self, model: Model) -> None:
        self._model, self._lever = model, model.coupling.lever_length
        door, map_ = model.scenario.door, model.scenario.estimation
        self._search = door.search, door.search_yaw
        self._doubt = math.hypot(map_.door_place_deviation, self._lever * map_.door_yaw_deviation)
        self._last: tuple[float, float] | None = None
        self._astray: float | None = None
        self._meets: float | None = None
        self._inside_since: float | None = None
        self._time = -math.inf
        self._was_there = False
        self.messages: list[tuple[float, str]] = []
        """What there is to say, with its time; taken by who records it."""
        self.refused = ""
        """Why the door cannot be flown to, in words."""
        self.lied = False
        """Whether the source of the leaf is not believed any more."""
        self._frame_time = -math.inf

    def checked(self, measured: Measurement, estimate: Estimate | None, tie: Tie) -> Measurement:
        """The measurement without a leaf that is not to be believed; `estimate` is that of the tick before."""
        leaf = measured.leaf
        if leaf is None:
            if self._was_there:
                self._was_there = False
                self.messages.append((measured.time, "the leaf is not measured any more"))
            return measured
        if not self._was_there and not self.lied:
            self._was_there = True
            where = self._model.door.in_words(self._model.door.angle_of_joint(leaf.joint))
            self.messages.append((measured.time, f"the leaf is measured, at {where}"))
        if leaf.time != self._time and not self.lied:
            self._time = leaf.time
            self._judge(measured, estimate, tie)
        if self.lied or self._astray is not None or self._inside_since is not None:
            return replace(measured, leaf=None)
        return measured

    def moves(self, frame: FrameReading | None) -> tuple[Array, float] | None:
        """Where a new reading of the frame has the hinge against the map, shape (2,) [m], and its turn [rad]; None if nowhere."""
        if frame is None or frame.time == self._frame_time:
            return None
        self._frame_time = frame.time
        door = self._model.door
        section = self._model.scenario.door
        drawn = np.linalg.inv(door.placement) @ [*door.hinge_position, 1.0]
        off = (frame.placed(drawn[:3]) - door.hinge_position)[:2]
        yaw = math.remainder(frame.yaw - section.yaw, 2.0 * math.pi)
        far, turned = float(np.hypot(*off)), abs(yaw)
        if far > self._search[0] or turned > self._search[1]:
            if not self.refused:
                where = f"{1e2 * far:.0f} cm and {math.degrees(turned):.0f}° beside the map"
                self.refused = f"the door's frame is measured {where}: too far from door.position and door.yaw"
                self.messages.append((frame.time, self.refused))
            return None
        return off, yaw

    def _judge(self, measured: Measurement, estimate: Estimate | None, tie: Tie) -> None:
        leaf, door = measured.leaf, self._model.door
        assert leaf is not None
        joint, time, deviation = leaf.joint, leaf.time, leaf.deviation / door.per_angle
        if self._last is not None:
            began = time if self._astray is None else self._astray
            lasted = max(began - self._last[1], 0.0) + _SLOWER * (time - began)
            if abs(joint - self._last[0]) > door.per_angle * _FASTEST * lasted + _UNLIKELY * 1.5 * leaf.deviation:
                self._astray = began
                if time - began > _JUMPED:
                    self._lie(measured.time, "they have jumped farther than a leaf can move")
                return
        step = 0.0 if self._last is None else time - self._last[1]
        self._astray, self._last = None, (joint, time)
        angle = door.angle_of_joint(joint)
        ends = not door.endless and door.lower_limit < door.upper_limit
        beyond = max(door.lower_limit - angle, angle - door.upper_limit, 0.0) if ends else 0.0
        if beyond > _BEYOND + _UNLIKELY * deviation:
            self._lie(measured.time, f"{door.way_in_words(beyond)} beyond where the joint ends")
            return
        if estimate is None or tie is Tie.FREE or tie is Tie.LEAVING:
            self._inside_since = None
            return
        # where the map has the tip: the estimate's face is moved to where the leaf is measured
        tip = estimate.tip_angle + self._model.coupling.angle_of_face(estimate.face_offset)
        gap = self._lever * (tip + (time - estimate.time) * estimate.door_rate - angle)
        sure, doubt = estimate.touching or tie is Tie.GRIPPED, _UNLIKELY * self._lever * deviation
        if self._meets is None:
            if sure and abs(gap) > _TELLS * self._doubt + _APART + doubt:
                self._lie(measured.time, f"the tip met the leaf {1e2 * abs(gap):.0f} cm from where it is measured")
            elif sure:
                self._meets = gap
            return
        off = self._meets - gap
        if sure or off > 0.0:
            self._meets -= min(step / _RELAXES, 1.0) * off
        if not (off > _INSIDE + doubt or (tie is Tie.GRIPPED and -off > _INSIDE + doubt)):
            self._inside_since = None
            return
        self._inside_since = time if self._inside_since is None else self._inside_since
        if time - self._inside_since > _LASTS:
            self._lie(measured.time, f"the leaf is measured {1e2 * abs(off):.1f} cm from where the tip has it")

    def _lie(self, now: float, why: str) -> None:
        self.lied = True
        self.messages.append((now, f"the leaf's readings are not believed any more: {why}"))
