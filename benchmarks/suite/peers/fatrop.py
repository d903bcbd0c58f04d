"""CasADi with fatrop: exact Hessians, structure found by CasADi, generated C."""

from __future__ import annotations

from suite.peers.program_peer import ProgramPeer
from suite.peers.shooting import COMPILED, ProgramSolver, Shooting
from suite.task import Task


class Fatrop(ProgramPeer):
    """fatrop's defaults but for the tolerance: the loosest that finds costs to 1e-6 from all states."""

    def __init__(self, task: Task) -> None:
        super().__init__(task)
        shooting = Shooting(task, initial_rows=True)
        options = {
            **COMPILED,
            "structure_detection": "auto",
            "equality": shooting.equal.tolist(),
            "fatrop": {"print_level": 0, "tol": 1e-7},
        }
        self.cold = ProgramSolver(shooting, "fatrop", options, fix_start=False)
