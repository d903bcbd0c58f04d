"""Peers that solve the shooting program to convergence by one of CasADi's plugins."""

from __future__ import annotations

from suite.peers.interface import Peer
from suite.peers.shooting import ProgramSolver
from suite.task import Answer, Array, hover_guess


class ProgramPeer(Peer):
    """A peer with `cold`, the solver that runs to convergence."""

    cold: ProgramSolver

    def prepare_cold(self, state: Array) -> None:
        """Guess: the state held, hover inputs."""
        self._active = self.cold
        self._active.guess(state, *hover_guess(self.task, state))

    def solve(self) -> None:
        """One call of CasADi's compiled interface."""
        self._active.run()

    def answer(self) -> Answer:
        """Trajectory and CasADi's own verdict."""
        states, inputs = self._active.trajectory()
        stats = self._active.stats
        claim = str(stats.get("unified_return_status") or stats["return_status"])
        success = bool(stats["success"])
        usable = success or self._active is not self.cold  # one iteration is used as it is
        return Answer(states, inputs, int(stats["iter_count"]), claim, usable, success)
