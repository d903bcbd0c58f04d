"""Cold solves from states off the way: who converges, who fails, and who says so."""

from __future__ import annotations

from typing import Any

from suite.judge import TOLERANCE, Judge, Optimum, Verdict
from suite.process import PeerError
from suite.session import Session
from suite.states import perturbed
from suite.task import Answer, Array
from suite.tasks import paper
from suite.workloads.cold import LOOP_STEPS, rotated

STARTS, QUICK_STARTS, PEER_STARTS = 1000, 100, 60
"""For doorman, for doorman in a quick run, and for the others, who are slower."""

SEED = 11


def measure(session: Session) -> dict[str, Any]:
    """1,000 perturbed states of the paper's loop; the first 60 for everybody."""
    task = paper()
    judge, loop, team = session.judge(task), session.loop(task, LOOP_STEPS), session.team(task)
    starts = perturbed(loop, QUICK_STARTS if session.quick else STARTS, SEED)
    peers = 10 if session.quick else PEER_STARTS
    rows = []
    for index, state in enumerate(starts):
        optimum, outside = judge.optimum(state), judge.starts_at(state)
        entrants = [process for process in team if process.name == "doorman" or index < peers]
        for process in rotated(entrants, index):
            if process.name != "doorman_timed":
                row = _solve(process.cold, judge, task.name, state, optimum)
                rows.append({"start": index, "outside": outside, "solver": process.name, **row})
    return {"rows": rows}


def _solve(cold: Any, judge: Judge, task: str, state: Array, optimum: Optimum) -> dict[str, Any]:
    try:
        (timing,), answer = cold(task, state, 1)
    except PeerError as error:
        return {"outcome": "exception", "error": str(error)}
    verdict = judge.verdict(state, answer)
    reference = optimum
    if answer.usable and not verdict.solves(optimum):  # a local minimum of either, or a failed reference: look again
        reference = judge.optimum(state, (answer.states, answer.inputs))
        if not reference.success:
            reference = optimum
    return {
        "outcome": _outcome(answer, verdict, optimum, reference),
        "seconds": timing.on_core, "claim": answer.claim, "usable": answer.usable,
        "gap": verdict.gap(reference), "violation": verdict.violation, "defect": verdict.defect,
        "iterations": answer.iterations, "recovered_at": judge.recovery(answer),
        "reference": bool(optimum.success or reference.success),
    }  # fmt: skip


def _outcome(answer: Answer, verdict: Verdict, optimum: Optimum, reference: Optimum) -> str:
    """What came of a start, in the words of `suite.tables.OUTCOMES`."""
    if verdict.solves(reference):
        return "converged" if verdict.solves(optimum) or not optimum.success else "another local minimum"
    if not answer.usable:
        return "on the way back, and said so" if answer.claim == "recovering" else "failed and said so"
    if max(verdict.violation, verdict.defect) > TOLERANCE:
        return "claims to hold, does not"
    return "holds, less optimal than it says" if answer.converged else "holds, stopped early"
