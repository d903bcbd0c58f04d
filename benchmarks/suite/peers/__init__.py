"""The solvers that are compared: where each is defined, and what it is called."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Literal

from suite.peers.interface import Peer

Problem = Literal["door", "standard", "push"]


@dataclass(frozen=True)
class Entry:
    """One solver."""

    label: str
    module: str
    factory: str
    ours: bool = False
    """Whether it runs in doorman's own environment."""
    problem: Problem = "door"
    """What it solves: the paper's door, the standard problems, or the whole-body push alone."""

    def load(self) -> type[Peer]:
        """Import it; only the environment that has it can."""
        package = "suite.peers" if self.problem == "door" else "suite.standard.peers"
        peer: type[Peer] = getattr(importlib.import_module(f"{package}.{self.module}"), self.factory)
        return peer


def _standard(label: str, module: str, factory: str, ours: bool = False) -> Entry:
    return Entry(label, module, factory, ours, "standard")


ENTRIES = {
    "doorman": Entry("doorman", "doorman_planner", "DoormanPlanner", ours=True),
    "doorman_timed": Entry("doorman, `elapsed` given", "doorman_planner", "TimedDoormanPlanner", ours=True),
    "ipopt": Entry("CasADi + IPOPT", "ipopt", "Ipopt"),
    "fatrop": Entry("CasADi + fatrop", "fatrop", "Fatrop"),
    "hpipm": Entry("CasADi sqpmethod + HPIPM", "sqp_hpipm", "SqpHpipm"),
    "hpipm_tuned": Entry("CasADi sqpmethod + HPIPM, tuned", "sqp_hpipm", "TunedSqpHpipm"),
    "hpipm_exact": Entry("CasADi sqpmethod + HPIPM, exact Hessian", "sqp_hpipm", "ExactSqpHpipm"),
    "acados_door": Entry("acados", "acados_sqp", "AcadosSqp"),
    "csqp": Entry("mim_solvers CSQP, Python callbacks", "csqp", "Csqp"),
    "pycddp": Entry("pycddp IPDDP, Python callbacks", "pycddp_interior_point", "InteriorPointDdp"),
    "whole_body": Entry("doorman", "doorman_push", "DoormanPush", ours=True, problem="push"),
    "hybrid": _standard("doorman", "doorman_hybrid", "DoormanHybrid", ours=True),
    "nlp_ipopt": _standard("CasADi + IPOPT, interpreted", "casadi_programs", "Ipopt"),
    "nlp_ipopt_c": _standard("CasADi + IPOPT, C", "casadi_programs", "CompiledIpopt"),
    "nlp_fatrop": _standard("CasADi + fatrop, interpreted", "casadi_programs", "Fatrop"),
    "nlp_fatrop_c": _standard("CasADi + fatrop, C", "casadi_programs", "CompiledFatrop"),
    "nlp_hpipm": _standard("CasADi sqpmethod + HPIPM, tuned, C", "casadi_programs", "SqpHpipm"),
    "acados": _standard("acados SQP, full steps, C", "acados_sqp", "AcadosSqp"),
    "acados_feasible": _standard("acados SQP, feasible programs and funnel, C", "acados_sqp", "FeasibleAcadosSqp"),
    "acados_slack": _standard("acados SQP, slacks and line search, C", "acados_sqp", "SlackAcadosSqp"),
    "aligator": _standard("aligator ProxDDP, C", "aligator_proxddp", "AligatorProxDdp"),
}
