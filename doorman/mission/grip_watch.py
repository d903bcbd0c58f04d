"""Whether a closed gripper holds the leaf: a loose tip leaves its place there, and feels nothing of a change of its push.

A tip that is pulled back through the place of a leaf at its stop is loose as well.
"""

from __future__ import annotations

import math
from collections import deque

from doorman.control.estimation.beliefs import VEHICLE_OBSERVER_RATE
from doorman.control.estimation.estimator import Estimate
from doorman.control.tug import TUG
from doorman.model import Model

_MOVES = 0.3 * TUG
"""Share of the weight, of a change of push or pull from which on the tip's force is looked at."""
_WINDOW = 0.5
"""Time over which both are looked at, less their mean [s]: of a pull that brakes an opening door friction may take all."""
_FELT = 0.25
"""Share of the push that leaf and hinge take at least: a leaf of 3 kg that nothing holds takes half of it."""
_SURELY = 0.12
"""For which it must have been less [s]."""
_OFF, _OFF_FOR = 0.03, 0.05
"""A tip that is so far beside its place on the leaf for so long has come off [m], [s]. A vehicle whose tip comes free turns about
its own centre, and the tip moves by 5 cm in 0.1 s. A held one seems to for 0.01 s, as a gap of 0.2 s in the poses ends."""
_JUMP = 0.01
"""A place that is so far off one tick later has not moved: the frame of the poses has jumped, or a gap has ended [m]."""
_BEHIND = 0.015
"""Farther back than where the gripper closed, and than the leaf's stop, no held tip comes [m]: it gives way by 1 mm at 5 N."""


class _Sums:
    """Sum and sum of squares of values that come and go, for their variance; beside the first one, so that no digits are lost."""

    def __init__(self) -> None:
        self._from: float | None = None
        self._sum = self._squares = 0.0

    def add(self, value: float) -> None:
        """Take one in."""
        if self._from is None:
            self._from = value
        beside = value - self._from
        self._sum += beside
        self._squares += beside * beside

    def remove(self, value: float) -> None:
        """Leave one out that was taken in."""
        beside = value - (self._from or 0.0)
        self._sum -= beside
        self._squares -= beside * beside

    def variance(self, count: int) -> float:
        """Of the values, which are so many."""
        mean = self._sum / count
        return max(self._squares / count - mean * mean, 0.0)


class GripWatch:
    r"""Feels whether the gripper holds, wherever the vehicle pushes or pulls.

    Of a change of its push, a vehicle whose tip holds the leaf feels the change of
    :math:`\lambda_n = \frac{I_D}{I_e}F_n - \frac{m_A D_V}{I_e}\tau`, a loose one nothing. The push is delayed as the estimated
    force is, by the three poles of the vehicle's observer. Deviations over a short window are compared: of a push that was felt
    before the gripper slipped nothing is left in it.

    A held tip stays where it is on the leaf. Its place follows slowly: about a hinge that is not where the map has it, it creeps.

    Args:
        model: Model of the scenario.
    """

    def __init__(self, model: Model) -> None:
        self._least = (_MOVES * model.vehicle.weight) ** 2
        self._rate = VEHICLE_OBSERVER_RATE
        self._poles = [0.0, 0.0, 0.0]
        self._recent: deque[tuple[float, float]] = deque()
        self._door, self._lever = model.door, model.coupling.lever_length
        self._stops = model.door.at_its_stop(model.start_angle)
        self._begin()
        self._gripped_at: float | None = None

    def _begin(self) -> None:
        self._recent.clear()
        self._pushed, self._answered = _Sums(), _Sums()
        self._loose_for = self._off_for = 0.0
        self._held: tuple[float, float] | None = None
        self._place: tuple[float, float] | None = None

    def is_loose(
        self, estimate: Estimate, place: tuple[float, float], closes: bool, holds: bool, time_step: float
    ) -> bool:
        """Take in what is known now; once per tick."""
        push = estimate.push
        for pole in range(3):
            self._poles[pole] += _share(self._rate * time_step) * (push - self._poles[pole])
            push = self._poles[pole]
        behind = (self._door.opening_of(self._door.stop) - self._door.opening_of(estimate.tip_angle)) * self._lever
        if not closes:
            self._gripped_at = None
        elif self._gripped_at is None:
            self._gripped_at = behind  # a door that opens before it is tugged comes back to here
        if not holds:
            self._begin()
            return False
        loose = self._feels_nothing(push, estimate.normal_force, time_step) or self._is_behind(behind)
        self._loose_for = self._loose_for + time_step if loose else 0.0
        self._off_for = self._off_for + time_step if self._is_off(place, time_step) else 0.0
        return self._loose_for > _SURELY or self._off_for > _OFF_FOR

    def _is_off(self, place: tuple[float, float], time_step: float) -> bool:
        """Whether the tip has left its place on the leaf [m]."""
        held, before, self._place = self._held or place, self._place or place, place
        if math.dist(before, place) > _JUMP:
            held = held[0] + place[0] - before[0], held[1] + place[1] - before[1]
        off, share = (place[0] - held[0], place[1] - held[1]), _share(time_step / _WINDOW)
        self._held = held[0] + share * off[0], held[1] + share * off[1]
        return math.hypot(*off) > _OFF

    def _feels_nothing(self, push: float, felt: float, time_step: float) -> bool:
        """Whether the push has changed in the window, and the tip's force has not [N]."""
        self._recent.append((push, felt))
        self._pushed.add(push)
        self._answered.add(felt)
        if len(self._recent) * time_step <= _WINDOW:
            return False
        first_push, first_felt = self._recent.popleft()
        self._pushed.remove(first_push)
        self._answered.remove(first_felt)
        pushed, answered = self._pushed.variance(len(self._recent)), self._answered.variance(len(self._recent))
        return pushed > self._least and answered < _FELT**2 * pushed

    def _is_behind(self, behind: float) -> bool:
        """Whether the tip is where the leaf would have had to come through its stop [m]."""
        return self._stops and behind > _BEHIND + max(self._gripped_at or 0.0, 0.0)


def _share(steps: float) -> float:
    """Share that a low-pass takes over in so many of its time constants."""
    return 1.0 - math.exp(-steps)
