"""One run of the comparison: its processes, judges and loops, made when first asked for."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from suite.judge import Judge
from suite.peers import ENTRIES
from suite.process import PeerError, Process
from suite.states import Loop, closed_loop
from suite.task import Task


@dataclass
class Session:
    """What the workloads of a run share.

    Args:
        folder: Where everything goes that the run leaves behind.
        names: Solvers to compare, keys of `ENTRIES`.
        python: Interpreter of doorman's environment.
        peers_python: Interpreter of the peers' environment.
        core: On which all solvers run.
        quick: Fewer states and repetitions.
    """

    folder: Path
    names: Sequence[str]
    python: Path
    peers_python: Path
    core: int
    quick: bool
    setup_seconds: dict[str, dict[str, float]] = field(default_factory=dict)
    """By task and solver: time to set up, compilation of generated code included."""
    missing: dict[str, dict[str, str]] = field(default_factory=dict)
    """By task and solver: why one could not be set up, in its own words."""
    _processes: dict[str, Process] = field(default_factory=dict)
    _judges: dict[str, Judge] = field(default_factory=dict)
    _loops: dict[tuple[str, int, int | None], Loop] = field(default_factory=dict)

    def team(self, task: Task, names: Sequence[str] | None = None) -> list[Process]:
        """The solvers that can solve a task, set up for it; as many at a time as there are cores.

        Args:
            task: The task.
            names: Solvers wanted; by default all of the session.
        """
        wanted = [name for name in (self.names if names is None else names) if name in self.names]
        setups, missing = self.setup_seconds.setdefault(task.name, {}), self.missing.setdefault(task.name, {})
        fresh = [name for name in wanted if name not in setups and name not in missing]
        at_once = max(os.cpu_count() or 1, 1)
        for batch in (fresh[i : i + at_once] for i in range(0, len(fresh), at_once)):
            for name in batch:
                self._process(name).begin("prepare", task)
            for name in batch:
                try:
                    setups[name] = self._processes[name].finish(timeout=900.0)
                except PeerError as error:
                    missing[name] = str(error)
        return [self._process(name) for name in wanted if name in setups]

    def release(self, task: Task) -> None:
        """Let the solvers forget a task that is not needed any more."""
        for name in self.setup_seconds.get(task.name, {}):
            try:
                self._process(name).drop(task.name)
            except PeerError:
                pass
        self.setup_seconds[f"{task.name} (done)"] = self.setup_seconds.pop(task.name, {})

    def judge(self, task: Task) -> Judge:
        """The task's judge."""
        if task.name not in self._judges:
            self._judges[task.name] = Judge(task)
        return self._judges[task.name]

    def loop(self, task: Task, steps: int, noise_seed: int | None = None) -> Loop:
        """A closed loop of the task's optima."""
        key = (task.name, steps, noise_seed)
        if key not in self._loops:
            self._loops[key] = closed_loop(self.judge(task), steps, noise_seed)
        return self._loops[key]

    def scratch(self, name: str) -> Path:
        """A folder for files of a workload."""
        path = self.folder / name
        path.mkdir(parents=True, exist_ok=True)
        return path

    def close(self) -> None:
        """End all processes."""
        for process in self._processes.values():
            process.close()

    def _process(self, name: str) -> Process:
        process = self._processes.get(name)
        if process is None or process.ended:
            python = self.python if ENTRIES[name].ours else self.peers_python
            process = self._processes[name] = Process(name, python, self.core, self.scratch("workers") / name)
        return process
