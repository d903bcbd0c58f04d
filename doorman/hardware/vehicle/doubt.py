"""Cameras that are believed as long as the autopilot, which feels every motion, does not contradict them.

Where a body is found again after a gap, cameras cannot know whether it has flown there: another body may be taken for it, its
markers may have moved, or one arm of a hexarotor is taken for the next. The autopilot's estimate drifts by centimetres and
fractions of a degree in such a gap. Poses far from it are lost ones, for controller, supervisor and for the autopilot itself,
which they would drag along. Where the cameras have followed the body without a gap since both agreed, it is the autopilot that
errs, and only their poses can bring it back.

Poses that have jumped from one frame to the next are lost ones, by however little: the cameras' frame, the markers or the body
are not those by which the vehicle took off. They are believed again once they have jumped back.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from doorman.hardware.mocap import PoseQuality, PoseSample
from doorman.hardware.pixhawk import Autopilot, SampleStatus
from doorman.kinematics.quaternions import angle_between

BELIEVED, BELIEVED_TURN = 0.15, 0.3
"""Distance and angle between cameras and autopilot below which poses are believed again [m], [rad]. A vehicle at 2 rad/s
turns less while the autopilot's state is late."""
DOUBTED, DOUBTED_TURN = 0.25, 0.45
"""Those beyond which poses are lost ones: less than half of what two arms of a hexarotor enclose [m], [rad]."""


class Doubt:
    """Judges poses in flight: while they are far from where the autopilot is, they are lost ones."""

    # Far away are positions of a body that was found again since both agreed, and attitudes of any.

    def __init__(self, autopilot: Autopilot, slack: float) -> None:
        self._autopilot, self._slack = autopilot, slack  # the latter of positions that have not jumped [m]
        self._agreed, self._shift = 0, (0.0, 0.0, 0.0)
        self._distrusted = False
        self.holds = False  # whether the last pose was far from where the autopilot is, and is not to be believed

    def distrust(self) -> None:
        """Something else contradicts the poses: they are lost until the vehicle is disarmed."""
        self._distrusted = True

    def __call__(self, pose: PoseSample) -> PoseSample:
        """The pose; lost while it is doubted."""
        state = self._autopilot.state()
        if not state.armed:  # on the ground it learns from the cameras where it is
            self.holds = self._distrusted = False
            self._agreed, self._shift = pose.track, pose.shift
        elif self._distrusted or math.dist(pose.shift, self._shift) > self._slack:
            self.holds = True
        elif pose.usable and state.status is SampleStatus.FRESH:
            apart = float(np.linalg.norm(pose.position - state.position))
            turned = angle_between(pose.quaternion.tolist(), state.quaternion.tolist())
            far, turn = (BELIEVED, BELIEVED_TURN) if self.holds else (DOUBTED, DOUBTED_TURN)
            self.holds = turned > turn or (apart > far and pose.track != self._agreed)
            if apart < BELIEVED and not self.holds:
                self._agreed = pose.track
        return replace(pose, quality=PoseQuality.LOST, fresh=False) if self.holds and pose.usable else pose
