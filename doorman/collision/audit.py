"""Audit of the analytic constraints by exact geometry: what do they allow that collides, and how much forbid in vain?

What the constraints do not know of: the arm's elbow against the leaf, and the disc against a sill. The elbow stays on
the vehicle's side of the leaf up to the tilt t with L + z sin t = R_A cos t. L is the length of the links between the second
joint, at depth z below O_B, and the last one. t is 0.68 rad (39°) for the shipped vehicle. The search of `audit` agrees: it
finds no collision up to 0.65 rad, for any yaw and any posture within the joint limits, and elbows through the leaf from
0.70 rad on.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from doorman.arrays import Array
from doorman.collision.reduced_model import ReducedModel
from doorman.collision.sampling import Constraints, Region
from doorman.collision.scene import Clearances, CollisionScene
from doorman.kinematics.coupling import Coupling
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.task_numbers import task_numbers
from doorman.one_line import OneLine


@dataclass(frozen=True)
class Offender:
    """A configuration that the constraints allow although shapes overlap."""

    state: tuple[float, ...]
    """x = [Φ, α, 0, H] [rad]."""
    first: str
    second: str
    depth: float
    """[m]."""


@dataclass(frozen=True, repr=False)
class AuditReport(OneLine):
    """Result of an audit."""

    sampled: int
    """Configurations drawn."""
    allowed: int
    """Configurations that the constraints allow and that went through FCL."""
    colliding: int
    """How many of them overlap by more than the tolerance."""
    worst: Offender | None
    """The deepest of them."""
    forbidden_free_share: float
    """Share of the drawn collision-free configurations that the constraints forbid."""
    max_tilt: float
    """Tilt range that was sampled [rad]."""
    tolerance: float
    """[m]."""
    enough: int
    """Allowed configurations that an audit needs to say anything."""

    @property
    def ok(self) -> bool:
        """Whether there were enough allowed configurations and none of them collides."""
        return self.allowed >= self.enough and self.colliding == 0

    @property
    def reason(self) -> str:
        """The verdict in one sentence."""
        if self.allowed < self.enough:
            few = f"only {self.allowed}" if self.allowed else "none"
            return (
                f"{few} of {self.sampled} sampled configurations are allowed by the constraints, "
                f"{self.enough} are needed: the constraints contradict each other or leave no room"
            )
        if self.worst is not None:
            return (
                f"{self.colliding} of {self.allowed} allowed configurations collide, "
                f"the worst by {1e3 * self.worst.depth:.1f} mm: {self.worst.first} in {self.worst.second}"
            )
        return (
            f"none of {self.allowed} allowed configurations collides up to a tilt of {np.degrees(self.max_tilt):.0f}°"
        )

    def as_dict(self) -> dict[str, Any]:
        """Everything as plain types, with `ok` and `reason`."""
        return {"ok": self.ok, "reason": self.reason, **asdict(self)}


TOLERANCE = 5e-4
"""Largest overlap that does not count as a collision [m]: FCL's accuracy, and the half thickness of the thin shapes."""

_BATCH = 200_000
_ENOUGH = 500
_SPREADS = tuple(0.1 / 2**k for k in range(5))
_CLOSEST_SHARE = 0.02
_COPIES = 12
_OUTSIDE = 4


def analytic_constraints(coupling: Coupling) -> Constraints:
    """The planner's constraints as a function of many states."""
    numbers = task_numbers(coupling.vehicle, coupling.door, coupling.distance_from_hinge, coupling.height)
    return ReducedModel(coupling.vehicle, numbers, time_step=1.0).constraints_along  # constraints know no time


def audit(
    coupling: Coupling,
    constraints: Constraints | None = None,
    *,
    door_angles: tuple[float, float],
    max_tilt: float = 0.5,
    draws: int = 1_000_000,
    checks: int = 2000,
    seed: int = 0,
) -> AuditReport:
    """Sample configurations on the kinematic constraint and hold the constraints against FCL."""
    rows = constraints or analytic_constraints(coupling)
    region = Region(coupling, door_angles, max_tilt)
    generator = np.random.default_rng(seed)
    scene = CollisionScene(coupling.vehicle, coupling.door)
    draw = _draw(region, rows, draws, checks, generator)
    boundary = draw.inside[:0]
    if len(draw.inside) and len(draw.outside):
        ends = draw.outside[generator.integers(len(draw.outside), size=len(draw.inside))]
        boundary = region.to_boundary(draw.inside, ends, rows)
    states = np.vstack([draw.inside, boundary])
    if len(states):
        states, distances, pairs = _search(
            region, rows, scene, states, max(4, round(_CLOSEST_SHARE * checks)), generator
        )
    else:
        distances, pairs = np.zeros(0), ()
    worst = None
    if len(states) and distances.min() < -TOLERANCE:
        index = int(np.argmin(distances))
        worst = Offender(tuple(states[index].tolist()), *pairs[index], depth=-float(distances[index]))
    return AuditReport(
        sampled=draw.sampled,
        allowed=len(states),
        colliding=int((distances < -TOLERANCE).sum()),
        worst=worst,
        forbidden_free_share=_forbidden_share(scene, coupling, draw),
        max_tilt=max_tilt,
        tolerance=TOLERANCE,
        enough=min(_ENOUGH, checks),
    )


@dataclass(frozen=True)
class _Draw:
    """Uniform random states, divided by the constraints."""

    sampled: int
    allowed_share: float
    inside: Array
    outside: Array


def _draw(region: Region, constraints: Constraints, draws: int, checks: int, generator: np.random.Generator) -> _Draw:
    sampled, allowed = 0, 0
    inside: list[Array] = []
    outside = np.zeros((0, 0))
    while sampled < draws and allowed < checks:
        states = region.draw(min(_BATCH, draws - sampled), generator)
        good = constraints(states).max(axis=1) <= 0.0
        sampled, allowed = sampled + len(states), allowed + int(good.sum())
        inside.append(states[good])
        outside = states[~good][: _OUTSIDE * checks] if not outside.size else outside
    return _Draw(sampled, allowed / sampled, np.vstack(inside)[:checks], outside)


def _search(
    region: Region,
    constraints: Constraints,
    scene: CollisionScene,
    states: Array,
    closest: int,
    generator: np.random.Generator,
) -> tuple[Array, Array, tuple[tuple[str, str], ...]]:
    """FCL at allowed states, then at allowed neighbours of the closest ones of every pair: states, distances, pairs."""
    found = clearances_at(scene, region.coupling, states)
    distances, pairs = found.distances, found.pairs
    for spread in _SPREADS:
        chosen = np.concatenate([_closest(distances, pairs, pair, closest) for pair in sorted(set(pairs))])
        around = region.near(states[chosen], spread, _COPIES, generator)
        around = around[region.allowed(around, constraints)]
        if len(around) == 0:
            continue
        found = clearances_at(scene, region.coupling, around)
        states, pairs = np.vstack([states, around]), pairs + found.pairs
        distances = np.concatenate([distances, found.distances])
    return states, distances, pairs


def _closest(
    distances: Array, pairs: tuple[tuple[str, str], ...], pair: tuple[str, str], count: int
) -> NDArray[np.int64]:
    """Indices of the closest states of one pair of shapes."""
    mine = np.array([k for k, other in enumerate(pairs) if other == pair], dtype=np.int64)
    return mine[np.argsort(distances[mine])[:count]]


def clearances_at(scene: CollisionScene, coupling: Coupling, states: Array, stop_below: float = -np.inf) -> Clearances:
    """Exact clearances of states on the kinematic constraint."""
    positions = np.array([coupling.vehicle_position(x[:3], float(x[3]), x[5:]) for x in states])
    rotations = np.array([rotation_body_to_world(x[:3]) for x in states])
    return scene.min_clearance_along(positions, rotations, states[:, 5:], states[:, 3], stop_below)


def _forbidden_share(scene: CollisionScene, coupling: Coupling, draw: _Draw) -> float:
    """Share of the drawn collision-free states that is forbidden."""
    free = clearances_at(scene, coupling, draw.outside, stop_below=-TOLERANCE).distances >= -TOLERANCE
    forbidden = (1.0 - draw.allowed_share) * float(free.mean())
    return forbidden / max(draw.allowed_share + forbidden, 1e-12)
