"""CasADi with IPOPT: exact Hessians, MUMPS (the only linear solver in the wheel), generated C."""

from __future__ import annotations

from suite.peers.program_peer import ProgramPeer
from suite.peers.shooting import COMPILED, ProgramSolver, Shooting
from suite.task import Task

QUIET = {"ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.max_iter": 500}


class Ipopt(ProgramPeer):
    """IPOPT's defaults but for the tolerance: the loosest that finds costs to 1e-6 from all states."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        self.cold = ProgramSolver(Shooting(task), "ipopt", {**QUIET, **COMPILED, "ipopt.tol": 1e-7})
