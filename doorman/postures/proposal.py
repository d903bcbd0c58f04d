"""Postures of start and goal: as the scenario gives them, the paper's where they keep all limits, else the widest.

What the scenario pins down is used as given. What it leaves open is the paper's: the arm's posture, for four joints, and the
heading along the leaf's normal. A posture that would break a joint limit or a constraint with its margin is searched instead,
level, over heading and arm. Of the widest postures (`room`) the nearest to the other end is taken to which a way inside the
constraints leads.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.collision.reduced_model import ReducedModel
from doorman.kinematics.contact import Contact
from doorman.kinematics.coupling import BESIDE
from doorman.kinematics.doors.door import Door
from doorman.kinematics.doors.leaf.travel import Travel
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.postures.room import Room
from doorman.postures.search import YAW, Found, different, joint_bounds, local_optima, pinned, widest
from doorman.scenario import GoalSection, Scenario, StartSection

PAPER_POSTURES: dict[str, tuple[float, ...]] = {
    "start.attitude": (0.0, 0.0, 0.0),
    "start.arm": (0.0, 1.0, -0.6, -0.4),
    "goal.attitude": (0.0, 0.0, -7 * math.pi / 18),
    "goal.arm": (0.0, math.pi / 2, -math.pi / 2, 0.0),
}
"""The paper's, by key of the scenario, for an arm of four joints [rad]."""

_RESERVE = 0.04
"""Beyond the margin, between disc and jamb at the goal of a tip that only presses: it may have slipped, and gusts blow [m]."""


@dataclass(frozen=True)
class End:
    """Start or goal."""

    name: str
    """`start` or `goal`."""
    door_angle: float
    """α [rad]."""
    attitude: tuple[float, ...] | None
    """Φ where the scenario pins it down [rad]."""
    arm: tuple[float, ...] | None
    """H where the scenario pins it down [rad]."""
    n_arm: int
    """Number of joints."""
    normal: float
    """Heading along the leaf's normal [rad]."""
    paper_arm: tuple[float, ...]
    """The paper's H, for four joints [rad]."""

    @classmethod
    def of(
        cls, name: str, section: StartSection | GoalSection, angle: float, door: Door, n_arm: int, share: float = 1.0
    ) -> End:
        """End of a scenario's section."""
        first, last = (np.array(PAPER_POSTURES[f"{end}.arm"]) for end in ("start", name))
        arm = tuple(((1.0 - share) * first + share * last).tolist())
        return cls(name, angle, section.attitude, section.arm, n_arm, door.heading(angle), arm)

    @property
    def free(self) -> NDArray[np.int64]:
        """Indices of x = [Φ, α, α̇, H] that a search may change: a vehicle that is free to turn stays level."""
        yaw = [] if self.attitude is not None else [YAW]
        return np.array([*yaw, *(range(5, 5 + self.n_arm) if self.arm is None else ())], dtype=np.int64)

    def state(self, arm: tuple[float, ...] | Array) -> Array:
        """Posture at rest with what is pinned down, along the leaf's normal where the attitude is not."""
        attitude = (0.0, 0.0, self.normal) if self.attitude is None else self.attitude
        return np.array([*attitude, self.door_angle, 0.0, *(arm if self.arm is None else self.arm)])

    def paper_state(self) -> Array | None:
        """Posture with the paper's arm; None for an arm with another number of joints that is not pinned down."""
        arm = self.paper_arm
        return None if self.arm is None and self.n_arm != len(arm) else self.state(arm)


def beside_the_normal(goal: Array, start: float, room: Room, scenario: Scenario, door: Door) -> Array:
    """Goal of a tip that may slip: in a narrow doorway its heading lies beside the normal, as on the way there."""
    goal, yaw = goal.copy(), float(goal[YAW])
    for beside in np.linspace(0.0, BESIDE, 15):
        goal[YAW] = yaw + door.hand * math.copysign(beside, start - goal[3])
        if room.to_latch(goal) < -(scenario.planner.margin + _RESERVE):
            break
    return goal


_SPACING = math.radians(7.5)
_ACROSS = np.linspace(0.0, 1.0, 15)


def turned(room: Room, state: Array, door_angle: float) -> Array:
    """The posture relative to the leaf, at another door angle."""
    other = state.copy()
    other[YAW] -= room.heading(state)
    other[3] = door_angle
    other[YAW] += room.heading(other)
    return other


def follow(room: Room, state: Array, door_angle: float) -> tuple[Array, bool]:
    """Follow the locally widest posture along the swing."""
    free = np.array([YAW, *range(5, len(state))])
    clear = bool(room.constraints(state).max() <= 0.0)
    start = float(state[3])
    for angle in np.linspace(start, door_angle, max(2, math.ceil(abs(door_angle - start) / _SPACING) + 1)):
        state = widest(room, turned(room, state, float(angle)), free).state
        clear = clear and bool(room.constraints(state).max() <= 0.0)
    return state, clear


def straight_way_is_clear(room: Room, first: Array, last: Array) -> bool:
    """Whether all postures between two keep the constraints, as heading and arm go straight from one to the other."""
    return bool(room.constraints_along(first + np.outer(_ACROSS, last - first)).max() <= 0.0)


_WHOLE_TURN = math.radians(69.9)
"""Turn of a leaf's face, as of the paper's, for which a pushing arm moves from its start to its goal [rad]. A slide's face does
not turn, and an arm that moves on a short way slows the push down."""
_AS_WIDE = 0.002
"""Postures whose widths differ by less are as wide as each other."""
_FIRST_ENDS = 3
"""Start postures that are tried where the goal is open as well."""
_ASIDE = 0.3
"""Headings beside the normal that a search starts from [rad]."""
_MOBILE = 1e-3
"""An arm that moves its tip by less along the normal cannot move it so [m/rad]."""


@dataclass(frozen=True)
class Postures:
    """Postures at rest of both ends."""

    start: Array
    """x = [Φ, α, 0, H] at the start, shape (5 + n,)."""
    goal: Array
    """x at the goal, shape (5 + n,)."""
    proposed: Mapping[str, tuple[float, ...]]
    """What the scenario leaves open, by key: `start.attitude`, `start.arm`, `goal.attitude`, `goal.arm` [rad]."""


def propose(scenario: Scenario, vehicle: Vehicle, door: Door, travel: Travel, reduced: ReducedModel) -> Postures:
    """Postures of start and goal."""
    finder = _Finder(scenario, vehicle, door, travel, reduced)
    ends = (("start", scenario.start, travel.start), ("goal", scenario.goal, travel.goal))
    cosine = float(door.away(travel.start) @ door.away(travel.goal))
    share = min(math.acos(min(max(cosine, -1.0), 1.0)) / _WHOLE_TURN, 1.0)
    if Contact.of(scenario).tied and not door.in_plane:
        share = 1.0
    start, goal = (End.of(name, section, angle, door, vehicle.n_arm, share) for name, section, angle in ends)
    first, last = finder.ends(start, goal)
    return Postures(first, last, {**_open(start, first), **_open(goal, last)})


def start_arm(scenario: Scenario, vehicle: Vehicle, door: Door, travel: Travel, reduced: ReducedModel) -> Array:
    """Arm of the start where no jamb is near: its reach decides how near to the hinge the tip may push."""
    finder = _Finder(scenario, vehicle, door, travel, reduced, jambs=False)
    return finder.alone(End.of("start", scenario.start, travel.start, door, vehicle.n_arm))[5:]


class _Finder:
    """Finds the postures of one scenario."""

    def __init__(
        self,
        scenario: Scenario,
        vehicle: Vehicle,
        door: Door,
        travel: Travel,
        reduced: ReducedModel,
        jambs: bool = True,
    ) -> None:
        self._scenario, self._vehicle, self._door, self._reduced, self._jambs = scenario, vehicle, door, reduced, jambs
        self._travel = travel
        self._contact = Contact.of(scenario)
        self._clear = Room(vehicle, door, reduced, margin=0.0, jambs=jambs)
        self._middle = 0.5 * np.add(*joint_bounds(vehicle))
        self._known: dict[str, list[Found]] = {}

    def ends(self, start: End, goal: End) -> tuple[Array, Array]:
        """Start and goal."""
        first, last = self._settled(start), self._settled(goal)
        if first is not None:
            return first, self._reached(goal, first) if last is None else last
        if last is not None:
            return self._reached(start, last), last
        best, largest, possible = (np.empty(0), np.empty(0)), -np.inf, self._optima(goal)[0].width
        for found in self._candidates(start)[:_FIRST_ENDS]:
            last = self._reached(goal, found.state)
            width = self._room(goal).width(last)
            if min(found.width, width) > largest + _AS_WIDE:
                best, largest = (found.state, last), min(found.width, width)
            if width >= possible - _AS_WIDE:  # later starts are narrower
                break
        return best

    def alone(self, end: End) -> Array:
        """Posture of an end, whatever the other is."""
        settled = self._settled(end)
        return self._candidates(end)[0].state if settled is None else settled

    def _settled(self, end: End) -> Array | None:
        """Posture of an end that needs no search: all of it is pinned down, or the paper's keeps the limits."""
        state, room = end.paper_state(), self._room(end)
        if state is None or not end.free.size:
            return state
        narrow = self._contact.fits and end.attitude is None
        if end.name == "goal" and narrow:
            state = beside_the_normal(state, self._travel.start, room, self._scenario, self._door)
        return state if room.keeps(state) else None

    def _reached(self, end: End, other: Array) -> Array:
        """Posture of an end with a way to the other end's."""
        there, clear = follow(self._clear, other, end.door_angle)
        found = self._candidates(end, there, turned(self._clear, other, end.door_angle))
        if clear:
            for posture in found:
                if posture.width >= 0.0 and straight_way_is_clear(self._clear, there, posture.state):
                    return posture.state
        return found[0].state

    def _candidates(self, end: End, *starts: Array) -> list[Found]:
        """Postures of an end, the best first: the widest, and of those that are as wide the nearest to the last start."""
        found = self._optima(end)
        plain = self._plain(end)
        found = different(
            [*found, *(widest(self._room(end), pinned(start, plain, end.free), end.free) for start in starts)]
        )
        near = starts[-1] if starts else plain
        as_wide = [one for one in found if one.width >= found[0].width - _AS_WIDE]
        as_wide.sort(key=lambda one: float(np.linalg.norm(one.state - near)))
        return [*as_wide, *found[len(as_wide) :]]

    def _optima(self, end: End) -> list[Found]:
        """Widest postures of an end, whatever the other is."""
        if end.name not in self._known:
            plain = self._plain(end)
            sides = [plain + aside * (np.arange(len(plain)) == YAW) for aside in (_ASIDE, -_ASIDE)]
            starts = (plain, *sides, end.state(self._middle))
            self._known[end.name] = local_optima(self._room(end), plain, end.free, starts)
        return self._known[end.name]

    def _plain(self, end: End) -> Array:
        """Posture along the normal, the paper's or in the middle of the joints' ranges."""
        paper = end.paper_state()
        return end.state(self._middle) if paper is None else paper

    def _room(self, end: End) -> Room:
        margin = self._scenario.planner.margin
        mobile = end.arm is None and self._can_move_along_the_normal(end)
        beside, steep = self._contact.beside, self._door.in_plane and self._contact.tied == 0.0
        if steep:  # a lever bears no force aside
            beside = math.inf
        return Room(self._vehicle, self._door, self._reduced, margin, beside, mobile, self._jambs, steep)

    def _can_move_along_the_normal(self, end: End) -> bool:
        generator, n = np.random.default_rng(0), self._vehicle.n_arm
        arms = generator.uniform(-1.0, 1.0, (10, n))
        return any(self._clear.mobility(end.state(arm)) > _MOBILE for arm in arms)


def _open(end: End, state: Array) -> dict[str, tuple[float, ...]]:
    values = {"attitude": state[:3], "arm": state[5:]}
    return {f"{end.name}.{key}": tuple(value.tolist()) for key, value in values.items() if getattr(end, key) is None}
