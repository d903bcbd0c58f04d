"""Bring a chain of masses to rest beside a wall, by moving its end.

State: positions of the masses after the first, which is fixed [m]; velocities of those in between [m/s].
Input: velocity of the last mass [m/s]. Problem and numbers are those of Wirsching, Bock and Diehl, "Fast NMPC of a chain of
masses connected by springs", CCA 2006, as in acados' example "chain_mass", with a hard wall.
"""

from typing import Any

import casadi as ca
import numpy as np
from example import Example

from doorman import ocp

MASSES = 4  # with the fixed one and the one that is moved
MASS, SPRING, LENGTH, WALL = 0.033, 1.0, 0.033, -0.05  # kg, N/m, m, m
FREE = MASSES - 2

x, u = ca.SX.sym("x", 3 * (2 * FREE + 1)), ca.SX.sym("u", 3)
places, velocities = ca.horzsplit(ca.reshape(x[: 3 * (FREE + 1)], 3, -1)), x[3 * (FREE + 1) :]
springs = [ends - begins for begins, ends in zip([ca.SX.zeros(3), *places[:-1]], places, strict=True)]
forces = [SPRING * (1 - LENGTH / ca.norm_2(spring)) * spring for spring in springs]
pulls = [(after - before) / MASS for before, after in zip(forces[:-1], forces[1:], strict=True)]
rate = ca.vertcat(velocities, u, *[pull - ca.vertcat(0, 0, 9.81) for pull in pulls])


def at_rest() -> np.ndarray:
    """State in which nothing moves, with the last mass 0.2 m farther for every spring, by Newton's method."""
    held = ca.substitute(ca.vertcat(*pulls), places[-1], ca.DM([6 * LENGTH * (FREE + 1), 0.0, 0.0]))
    unknown = x[: 3 * FREE]
    balance = ca.Function("balance", [unknown], [held - ca.repmat(ca.DM([0, 0, 9.81]), FREE, 1)])
    line = np.outer(np.arange(1, FREE + 1), [6 * LENGTH, 0.0, 0.0]) - [0.0, 0.0, 0.3]
    found = np.array(ca.rootfinder("rest", "newton", balance)(line.ravel())).ravel()
    return np.concatenate([found, [6 * LENGTH * (FREE + 1), 0.0, 0.0], np.zeros(3 * FREE)])


rest = at_rest()
weights = [2.0] * 3 * FREE + [2.0 * (FREE + 1)] * 3 + [2.0] * 3 * FREE
cost = ocp.QuadraticCost(
    state_weights=weights, terminal_weights=weights, input_weights=[2e-2] * 3, state_goal=rest, input_goal=[0.0] * 3
)  # fmt: skip
beside = [-np.inf, WALL, -np.inf] * (FREE + 1) + [-np.inf] * 3 * FREE


def calm(states: np.ndarray) -> bool:
    """Whether the chain rests where it should."""
    return bool(np.abs(states[-1] - rest).max() < 0.05)


def draw(axes: Any, states: np.ndarray) -> None:
    """The chain from above at some times, and the wall."""
    for state in states[::4]:
        chain = np.vstack([np.zeros(3), state[: 3 * (FREE + 1)].reshape(-1, 3)])
        axes.plot(chain[:, 0], chain[:, 1], "o-", markersize=3)
    axes.axhline(WALL, color="#D55E00")
    axes.set(xlabel="x [m]", ylabel="y [m]")


EXAMPLE = Example(
    name="chain of masses", source="Wirsching et al. 2006, and acados, chain_mass",
    model=ocp.SymbolicModel(x, u, rate, steps=2), rate=rate, horizon=40, time_step=0.2,
    cost=cost, bounds=ocp.Bounds(state_lower=beside, input_lower=[-1.0] * 3, input_upper=[1.0] * 3),
    start=rest + np.array([-0.4, 0.5, 0.2, -0.8, 0.9, 0.5, -1.0, 1.0, 1.0, *[0.0] * 6]),
    spread=[0.1] * 9 + [0.5] * 6,
    steps=40, noise=[1e-3] * 9 + [5e-3] * 6, reached=calm, draw=draw,
)  # fmt: skip

if __name__ == "__main__":
    EXAMPLE.main()
