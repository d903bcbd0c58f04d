"""Solve one optimal control problem from many starts at once, on all cores."""

import casadi as ca
import numpy as np

from doorman.ocp import Bounds, Cddp, Constraint, QuadraticCost, SymbolicModel

x, u = ca.SX.sym("x", 2), ca.SX.sym("u")  # a mass on a line: position and velocity; force
model = SymbolicModel(x, u, ca.vertcat(x[1], u))
cost = QuadraticCost(
    state_weights=[1.0, 0.1],
    terminal_weights=[100.0, 10.0],
    input_weights=[0.1],
    state_goal=[0.0, 0.0],
    input_goal=[0.0],
)
slow = Constraint("speed", x[1], unit="m/s", lower=-1.0, upper=1.0)
problem = model.problem(40, 0.05, cost, bounds=Bounds(input_lower=[-3.0], input_upper=[3.0]), constraints=[slow])

starts = np.random.default_rng(0).uniform([-2.0, -0.5], [2.0, 0.5], (200, 2))
solutions = Cddp(problem).solve_batch(starts)
good = [solution for solution in solutions if not isinstance(solution, Exception) and solution.usable]
print(f"{len(good)} of {len(starts)} solved; costs {min(s.cost for s in good):.2f} to {max(s.cost for s in good):.2f}")
