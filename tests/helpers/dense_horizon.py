"""A whole horizon as one dense program, built from a workspace entry by entry: the plain twin of the sweeps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from doorman.ocp.solvers.memory.workspace import Workspace

Array = NDArray[np.float64]


@dataclass
class DenseHorizon:
    r"""min ½ zᵀHz + gᵀz over z = [δx_first … δx_N, δu_first … δu_{N−1}] along the linearised dynamics.

    Args:
        work: Workspace with a nominal trajectory and its linearisation.
        first: Node to begin with.
    """

    work: Workspace
    first: int = 0

    def __post_init__(self) -> None:
        work = self.work
        (self.n, self.nu), self.nx = work.nominal.inputs.shape, work.nominal.states.shape[1]
        self.steps = self.n - self.first
        self.size = (self.steps + 1) * self.nx + self.steps * self.nu
        self.hessian, self.gradient = np.zeros((self.size, self.size)), np.zeros(self.size)
        weights = work.weights
        for k in range(self.first, self.n + 1):
            x = self.state(k)
            diagonal = weights.terminal if k == self.n else weights.state
            self.hessian[x, x] += np.diag(diagonal)
            self.gradient[x] += diagonal * (work.nominal.states[k] - weights.state_goal)
            if k < self.n:
                u = self.input(k)
                self.hessian[u, u] += np.diag(weights.input)
                self.gradient[u] += weights.input * (work.nominal.inputs[k] - weights.input_goal)

    def state(self, k: int) -> slice:
        """Place of δx_k in z."""
        start = (k - self.first) * self.nx
        return slice(start, start + self.nx)

    def input(self, k: int) -> slice:
        """Place of δu_k in z."""
        start = (self.steps + 1) * self.nx + (k - self.first) * self.nu
        return slice(start, start + self.nu)

    def regularize(self, share: float) -> None:
        """Add a share of the input weights to themselves."""
        for k in range(self.first, self.n):
            self.hessian[self.input(k), self.input(k)] += share * np.diag(self.work.weights.input)

    def penalize(self, slope: Array, force: float, penalty: float) -> None:
        """Add ½ penalty (slope z)² + force slope z."""
        self.hessian += penalty * np.outer(slope, slope)
        self.gradient += force * slope

    def rows(self) -> list[tuple[str, tuple[int, ...], Array, float, float]]:
        """All rows and bounds of the nodes after the first: field, index, slope by z, value, multiplier.

        A bound has two rows, of its upper and of its lower end, told apart by the last number of its index, 1 or −1; values
        are positive where violated, multipliers not negative where their side is the one that pushes.
        """
        work, found = self.work, []
        nominal, linear, multipliers, limits = work.nominal, work.linear, work.multipliers, work.limits
        for k in range(self.first, self.n):
            x, u, ahead = self.state(k), self.input(k), self.state(k + 1)
            for i in range(nominal.rows.shape[1]):
                slope = np.zeros(self.size)
                slope[ahead] = linear.row_jacobians[k, i, : self.nx]
                found.append(("rows", (k, i), slope, nominal.rows[k, i], multipliers.rows[k, i]))
            for i in range(nominal.input_rows.shape[1]):
                slope, row = np.zeros(self.size), linear.input_row_jacobians[k, i]
                slope[x], slope[u] = row[: self.nx], row[self.nx + 1 : self.nx + 1 + self.nu]
                found.append(("input_rows", (k, i), slope, nominal.input_rows[k, i], multipliers.input_rows[k, i]))
            for what, place, size, value, given in (
                ("state", ahead, self.nx, nominal.states[k + 1], multipliers.states[k]),
                ("input", u, self.nu, nominal.inputs[k], multipliers.inputs[k]),
            ):
                for i in range(size):
                    for side, end in ((1, "upper"), (-1, "lower")):
                        limit = getattr(limits, f"{what}_{end}")[i]
                        if np.isfinite(limit):
                            slope = np.zeros(self.size)
                            slope[place.start + i] = side
                            index = (k, i, side)
                            found.append((f"{what}s", index, slope, side * (value[i] - limit), side * given[i]))
        for i in range(nominal.end_rows.shape[0]):
            slope = np.zeros(self.size)
            slope[self.state(self.n)] = linear.end_row_jacobians[i, : self.nx]
            found.append(("end_rows", (i,), slope, nominal.end_rows[i], multipliers.end_rows[i]))
        return found

    def is_active(self, name: str, index: tuple[int, ...]) -> bool:
        """Whether the workspace takes a row for active."""
        sides = getattr(self.work.active, name)
        return bool(sides[index[:2]] == index[2]) if len(index) == 3 else bool(sides[index])

    def penalize_active(self, penalty: float) -> None:
        """Penalties and multipliers of everything that the workspace takes for active."""
        for name, index, slope, value, multiplier in self.rows():
            if self.is_active(name, index):
                stiff = self.penalty_of(name, index, penalty)
                self.penalize(slope, multiplier + stiff * value, stiff)

    def penalty_of(self, name: str, index: tuple[int, ...], penalty: float) -> float:
        """Penalty of a row: those of early states take more."""
        return penalty * float(self.work.stiffness[index[0]]) if name in ("rows", "states") else penalty

    def solve(self, first_step: Array) -> Array:
        """Minimum z by one KKT system, with δx_first given."""
        equal = np.zeros(((self.steps + 1) * self.nx, self.size))
        right = np.zeros(len(equal))
        equal[: self.nx, self.state(self.first)], right[: self.nx] = np.eye(self.nx), first_step
        for k in range(self.first, self.n):
            row = slice((k - self.first + 1) * self.nx, (k - self.first + 2) * self.nx)
            jacobian = self.work.linear.jacobians[k]
            equal[row, self.state(k + 1)] = np.eye(self.nx)
            equal[row, self.state(k)] = -jacobian[:, : self.nx]
            equal[row, self.input(k)] = -jacobian[:, self.nx + 1 : self.nx + 1 + self.nu]
            right[row] = jacobian[:, self.nx]
        kkt = np.block([[self.hessian, equal.T], [equal, np.zeros((len(equal), len(equal)))]])
        return np.linalg.solve(kkt, np.concatenate([-self.gradient, right]))[: self.size]

    def states_and_inputs(self, z: Array) -> tuple[Array, Array]:
        """δX and δU of a solution."""
        cut = (self.steps + 1) * self.nx
        return z[:cut].reshape(-1, self.nx), z[cut:].reshape(-1, self.nu)
