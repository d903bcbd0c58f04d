"""The solvers that are compared: where each is defined, and what it is called."""

from __future__ import annotations

import importlib
from dataclasses import dataclass

from suite.peers.interface import Peer


@dataclass(frozen=True)
class Entry:
    """One solver."""

    label: str
    module: str
    factory: str
    ours: bool = False
    """Whether it runs in doorman's own environment."""

    def load(self) -> type[Peer]:
        """Import it; only the environment that has it can."""
        peer: type[Peer] = getattr(importlib.import_module(f"suite.peers.{self.module}"), self.factory)
        return peer


ENTRIES = {
    "doorman": Entry("doorman", "doorman_planner", "DoormanPlanner", ours=True),
    "doorman_timed": Entry("doorman, `elapsed` given", "doorman_planner", "TimedDoormanPlanner", ours=True),
    "ipopt": Entry("CasADi + IPOPT", "ipopt", "Ipopt"),
    "fatrop": Entry("CasADi + fatrop", "fatrop", "Fatrop"),
    "hpipm": Entry("CasADi sqpmethod + HPIPM", "sqp_hpipm", "SqpHpipm"),
    "hpipm_tuned": Entry("CasADi sqpmethod + HPIPM, tuned", "sqp_hpipm", "TunedSqpHpipm"),
    "hpipm_exact": Entry("CasADi sqpmethod + HPIPM, exact Hessian", "sqp_hpipm", "ExactSqpHpipm"),
    "csqp": Entry("mim_solvers CSQP, Python callbacks", "csqp", "Csqp"),
    "pycddp": Entry("pycddp IPDDP, Python callbacks", "pycddp_interior_point", "InteriorPointDdp"),
}
