r"""Room of a posture at rest: its distances from everything that bounds it, each in a measure of its own.

- constraints: :math:`-(h_i(x) + m)` beyond the margin m [m],
- joints: :math:`(\eta_j - l_j)/(u_j - l_j)` and :math:`(u_j - \eta_j)/(u_j - l_j)`, shares of the range,
- mobility: :math:`\lVert J_d^T R^T n_D\rVert`, by how much the arm moves the tip along the leaf's normal [m/rad]; it is zero in
  a singular posture,
- of an arm with mass: the centre of mass' distance from where the rotors no longer hold the vehicle level, see `Balance` [m],
- of a tip that slips under a force aside: :math:`n_D^T R d\,\tan\beta \mp t^T R d` along the level direction t in the face, so
  that the tip lies within β of the normal [m],
- of a tip that presses on a lever: :math:`\pm e_3^T R\,(d - s) - \lvert d - s\rvert\sin\gamma`, down or up, with the last link
  from s to the tip, which meets the lever with its end and not with its side [m].

The width of a posture is the least of them.
"""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.collision.reduced_model import ReducedModel
from doorman.collision.rows.jambs import JAMBS
from doorman.kinematics.doors.door import Door
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.kinematics.vehicles.balance import balance_of
from doorman.kinematics.vehicles.vehicle import Vehicle

_DIFFERENCE = 1e-6
"""For the slopes of the mobility [rad]."""
_SMALLEST_MOBILITY = 1e-9
_STEEP = math.sin(math.radians(25.0))
"""sin γ of the least angle γ between a lever and the last link that presses on it: the vehicle pitches, and the lever is thin."""
_UP = np.array([0.0, 0.0, 1.0])


class Room:
    """Distances of postures x = [Φ, α, α̇, H] from what bounds them."""

    def __init__(
        self,
        vehicle: Vehicle,
        door: Door,
        reduced: ReducedModel,
        margin: float,
        beside: float = math.inf,
        mobile: bool = False,
        jambs: bool = True,
        steep: bool = False,
    ) -> None:
        self.vehicle, self.margin, self._door, self._reduced = vehicle, margin, door, reduced
        self._beside_at_most, self._mobile, self._is_steep = beside, mobile, steep
        self._balance = balance_of(vehicle)
        self._leaf = len(vehicle.point_names)
        self._latch = reduced.row_names.index(JAMBS[0]) if JAMBS[0] in reduced.row_names else None
        self._counted = self._leaf + (reduced.n_rows - self._leaf if jambs else 1)
        span = vehicle.upper_limits - vehicle.lower_limits
        self._bounded = np.flatnonzero(np.isfinite(span) & (span > 0.0))
        self._lower, self._span = vehicle.lower_limits[self._bounded], span[self._bounded]

    def constraints(self, state: Array) -> Array:
        """Values h(x) of the constraints that count."""
        return self._reduced.constraints(state)[: self._counted]

    def to_latch(self, state: Array) -> float:
        """Value of the constraint between disc and latch jamb; −∞ where the door has none [m]."""
        return -math.inf if self._latch is None else float(self._reduced.constraints(state)[self._latch])

    def constraint_slopes(self, state: Array) -> Array:
        """Jacobian ∂h/∂x of `constraints`."""
        return self._reduced.constraint_jacobian(state)[: self._counted]

    def constraints_along(self, states: Array) -> Array:
        """Values of `constraints` at many states."""
        return self._reduced.constraints_along(states)[:, : self._counted]

    def keeps(self, state: Array, tolerance: float = 1e-9) -> bool:
        """Whether a posture is inside the joint limits, and inside the constraints by the margin."""
        vehicle, arm = self.vehicle, state[5:]
        inside = bool(((arm >= vehicle.lower_limits) & (arm <= vehicle.upper_limits)).all())
        inside = inside and float(self._balanced(state).min(initial=np.inf)) >= -tolerance
        inside = inside and not (self._is_steep and self._steepness(state) < -tolerance)
        return inside and float(self.constraints(state).max()) <= tolerance - self.margin

    def mobility(self, state: Array) -> float:
        """Speed of the tip along the normal for a unit speed of the arm's joints [m/rad]."""
        return float(
            np.linalg.norm(self.constraint_slopes(state)[self._leaf, 5:])
        )  # h of the leaf falls as the tip goes there

    def width(self, state: Array) -> float:
        """Least distance; negative where the posture breaks a joint limit or a constraint with its margin."""
        return float(self.distances(state).min())

    def distances(self, state: Array) -> Array:
        """All distances of a posture, in the order of the module's list."""
        rows = [-(self.constraints(state) + self.margin), *self._joints(state), self._balanced(state)]
        if self._mobile:
            rows.append(np.array([self.mobility(state)]))
        if math.isfinite(self._beside_at_most):
            rows.append(self._beside(state))
        if self._is_steep:
            rows.append(np.array([self._steepness(state)]))
        return np.concatenate(rows)

    def slopes(self, state: Array) -> Array:
        """Jacobian of `distances`."""
        of_constraints = self.constraint_slopes(state)
        share = np.zeros((len(self._bounded), len(state)))
        share[np.arange(len(self._bounded)), 5 + self._bounded] = 1.0 / self._span
        rows = [-of_constraints, share, -share, self._balance_slopes(state)]
        if self._mobile:
            rows.append(self._mobility_slopes(state, of_constraints)[None])
        if math.isfinite(self._beside_at_most):
            rows.append(self._beside_slopes(state))
        if self._is_steep:
            rows.append(self._steepness_slopes(state))
        return np.concatenate(rows)

    def rough_widths(self, states: Array) -> Array:
        """Widths of many postures by constraints and joints alone."""
        shares = np.array(self._joints(states)).min(axis=0)
        widths = -(self.constraints_along(states).max(axis=1) + self.margin)
        return np.asarray(np.minimum(widths, shares.min(axis=1, initial=np.inf)))

    def _joints(self, states: Array) -> tuple[Array, Array]:
        """Shares of the joints' ranges below and above one posture, or many."""
        share = (states[..., 5 + self._bounded] - self._lower) / self._span
        return share, 1.0 - share

    def _balanced(self, state: Array) -> Array:
        return np.zeros(0) if self._balance is None else self._balance.room(self.vehicle.center_of_mass(state[5:]))

    def _balance_slopes(self, state: Array) -> Array:
        if self._balance is None:
            return np.zeros((0, len(state)))
        slopes = np.zeros((len(self._balance.reaches), len(state)))
        slopes[:, 5:] = -self._balance.normals @ self.vehicle.center_of_mass_jacobian(state[5:])[:2]
        return slopes

    def _mobility_slopes(self, state: Array, of_constraints: Array) -> Array:
        """By differences of the constraints' exact slopes: a second derivative of the arm."""
        along = of_constraints[self._leaf, 5:]
        size, slopes = max(float(np.linalg.norm(along)), _SMALLEST_MOBILITY), np.zeros(len(state))
        for k in (2, *range(5, len(state))):
            moved = state.copy()
            moved[k] += _DIFFERENCE
            change = self.constraint_slopes(moved)[self._leaf, 5:] - along
            slopes[k] = float(along @ change) / (size * _DIFFERENCE)
        return slopes

    def _beside(self, state: Array) -> Array:
        tip = rotation_body_to_world(state[:3]) @ self.vehicle.tip_position(state[5:])
        return self._limits_beside(state) @ tip

    def _beside_slopes(self, state: Array) -> Array:
        rotation, slopes = rotation_body_to_world(state[:3]), np.zeros((2, len(state)))
        limits, tip = self._limits_beside(state), rotation @ self.vehicle.tip_position(state[5:])
        slopes[:, 2] = limits @ np.cross(_UP, tip)
        slopes[:, 5:] = limits @ rotation @ self.vehicle.tip_jacobian(state[5:])
        return slopes

    def _steepness(self, state: Array) -> float:
        *_, before, tip = self.vehicle.point_positions(state[5:])
        return float(self._plumb(state) @ (tip - before) - _STEEP * np.linalg.norm(tip - before))

    def _steepness_slopes(self, state: Array) -> Array:
        *_, before, tip = self.vehicle.point_jacobians(state[5:])
        return np.concatenate([np.zeros(5), self._plumb(state) @ (tip - before)])[None]

    def _plumb(self, state: Array) -> Array:
        """Down, or up on a lever that is pressed from below, in the body's frame; of a heading it is the same for all."""
        sense = math.copysign(1.0, float(self._door.normal(float(state[3]))[2]))
        return np.asarray(sense * rotation_body_to_world(state[:3])[2])

    def heading(self, state: Array) -> float:
        """Heading of a vehicle that looks along the leaf's normal [rad]."""
        return self._door.heading(float(state[3]))

    def _limits_beside(self, state: Array) -> Array:
        angle = float(state[3])
        ahead, aside = math.tan(self._beside_at_most) * self._door.normal(angle), self._door.face(angle)[0]
        return np.array([ahead - aside, ahead + aside])
