r"""A bank of extended Kalman filters with Markov switching, of expressions (interacting multiple model).

One filter for each hypothesis. Between measurements each of them predicts by its own dynamics; measurements narrow it, and
change its probability by how well it foretold them. H. A. P. Blom and Y. Bar-Shalom: The interacting multiple model algorithm for
systems with Markovian switching coefficients, IEEE Transactions on Automatic Control 33(8), 1988.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array, sealed
from doorman.checks import number, numbers, vector, whole
from doorman.compilation import entry
from doorman.copying import Uncopied
from doorman.estimation.estimate import FilterEstimate, MeasurementScore
from doorman.estimation.expressions import checked_names
from doorman.estimation.hypothesis import Hypothesis
from doorman.estimation.kernels import bank, history
from doorman.estimation.measurement import Measurement
from doorman.estimation.model import ProcessModel
from doorman.estimation.output import Output
from doorman.estimation.printed.compiled import memory_of
from doorman.estimation.printed.filter_text import functions_of, text_of
from doorman.estimation.status import Status
from doorman.exceptions import DimensionError, DoormanError
from doorman.numba_types.handles import held, separate

_ROUNDING = 1e-9
"""Relative error of a symmetric covariance that is given."""


class Filter(Uncopied):
    r"""State, covariance and probabilities of hypotheses, from commands and late measurements.

    Of hypotheses i and j with rates of switching :math:`r_{ij}`, each filter begins every interval h with the mixture of all,

    .. math::
        \pi_{ij} = (1 - e^{-s_i h})\frac{r_{ij}}{s_i},\quad s_i = \sum_{j \ne i} r_{ij},\quad
        c_j = \sum_i \pi_{ij} p_i,\quad \bar x_j = \sum_i \frac{\pi_{ij} p_i}{c_j} x_i,

    predicts by its own model, fuses its own rows and the measurements, and ends with :math:`p_j \propto c_j L_j`, where L is the
    density of its innovations. All expressions are compiled once, and kept on disk.

    ::

        filter = Filter(model, measurements=[Measurement("position", x[:3], 0.002)])
        filter.start(0.0, mean, deviations)
        filter.measure("position", 0.004, reading)  # stamped; may come late
        status = filter.step(0.012, commands)  # which hold from 0.012 s on
        print(filter.estimate().mean)

    Args:
        model: What moves the state.
        measurements: What sensors read.
        hypotheses: What may be true; without any, the model alone.
        switching: Rates of (from, to) [1/s]: numbers, or expressions of the state under the first of both; 0 where not given.
        outputs: Further quantities of the estimate.
        allowed: Names of hypotheses that are possible together, by the name of a situation; see `allow`.
        parameters: Values of the model's parameters, (np,).
        ticks: How many steps are kept: a measurement that is older is refused.
        longest_step: Time between two steps beyond which the clock has jumped [s].

    Raises:
        DoormanError: if names are unknown or used twice, an expression has an unknown symbol, or no situation allows a
            hypothesis.
    """

    def __init__(
        self, model: ProcessModel, measurements: Sequence[Measurement] = (), hypotheses: Sequence[Hypothesis] = (), *,
        switching: Mapping[tuple[str, str], Any] | None = None, outputs: Sequence[Output] = (),
        allowed: Mapping[str, Sequence[str]] | None = None, parameters: ArrayLike = (), ticks: int = 64,
        longest_step: float = 0.5,
    ) -> None:  # fmt: skip
        hypotheses = tuple(hypotheses) or (Hypothesis("model"),)
        self._model, self._hypotheses = model, tuple(each.name for each in hypotheses)
        self._measurements = {each.name: place for place, each in enumerate(measurements)}
        self._outputs = tuple(each.name for each in outputs)
        for field, names in (
            ("hypotheses", self._hypotheses), ("outputs", self._outputs),
            ("measurements", [each.name for each in measurements]),
        ):  # fmt: skip
            checked_names(field, list(names))
        switching = {} if switching is None else switching
        self._check_hypotheses("switching", [name for pair in switching for name in pair])
        special = [(each.name, each.under) for each in outputs] + [(each.name, each.under) for each in measurements]
        for name, under in special:
            self._check_hypotheses(f"{name}.under", under)
        self._allowed = self._checked_situations(allowed)
        if not longest_step > 0.0:
            raise DimensionError("not a time", field="longest_step", given=longest_step, allowed="> 0 s")
        functions = functions_of(model, measurements, hypotheses, switching, outputs)
        self._sizes = [each.rows for each in functions[4 * len(hypotheses) :: len(hypotheses)]]
        self._memory = memory_of(
            text_of(model, functions, hypotheses, measurements), functions, model, measurements, len(hypotheses),
            len(outputs), vector(parameters, int(model.parameters.numel()), "parameters"), whole(ticks, "ticks", 3),
        )  # fmt: skip
        n, count = model.size, len(hypotheses)
        self._size = (2 + n + count) * n + count + 2 * len(outputs)  # how many numbers an estimate has
        self._memory.progress.longest_step = longest_step
        self._handle = held(self._memory)
        self._begin = entry(history.start, self._handle, 0.0)
        self._store = entry(history.store, self._handle, 0, 0.0, 0)
        self._step = entry(history.step, self._handle, 0.0)
        self._report = entry(bank.fill_report, self._handle, np.empty(0))

    @property
    def time(self) -> float:
        """Time of the last step [s]; NaN before the start."""
        return float(self._memory.kept_times[self._newest]) if self.running else math.nan

    @property
    def _newest(self) -> int:
        """Place of the last step in the ring."""
        return self._memory.progress.last % self._memory.kept_times.size

    @property
    def running(self) -> bool:
        """Whether it was started and not lost."""
        return bool(self._memory.progress.running)

    @property
    def hypotheses(self) -> tuple[str, ...]:
        """Their names, in their order."""
        return self._hypotheses

    @property
    def parameters(self) -> Array:
        """Values of the model's parameters, (np,); those that are written act from the next step on."""
        return self._memory.parameters

    def with_numbers(self, parameters: ArrayLike, lower: ArrayLike, upper: ArrayLike, gate: float) -> Filter:
        """A filter of the same expressions with numbers of its own, not started: nothing is printed or compiled for it.

        Args:
            parameters: Values of the model's parameters, (np,).
            lower: Least values of the states, (n,).
            upper: Largest values of the states, (n,).
            gate: Of all measurements [deviations].

        Raises:
            DoormanError: if a size does not fit, or a parameter is not finite.
        """
        n, twin = self._model.size, object.__new__(type(self))
        twin.__dict__.update(self.__dict__)
        twin._memory = memory = separate(self._memory)
        memory.parameters[:] = vector(parameters, memory.parameters.size, "parameters")
        memory.lower[:], memory.upper[:] = _rows(lower, n, "lower"), _rows(upper, n, "upper")
        memory.gates[:] = number(gate, "gate") ** 2
        memory.progress.running = 0
        twin._handle = held(memory)
        return twin

    def start(
        self, time: float, mean: ArrayLike, deviations: ArrayLike, *, probabilities: Mapping[str, float] | None = None,
        inputs: ArrayLike | None = None, situation: str | None = None,
    ) -> None:  # fmt: skip
        """Begin, or begin anew.

        Args:
            time: Now [s].
            mean: State of all hypotheses, (n,).
            deviations: Of the state, (n,), or its covariance, (n, n).
            probabilities: By hypothesis; all equal if not given. They are scaled to a sum of 1.
            inputs: What acts from now on, (m,); zeros if not given.
            situation: As in `allow`; all hypotheses if not given.

        Raises:
            DoormanError: if a size does not fit, a number is not finite, or a name is unknown.
        """
        memory, n = self._memory, self._model.size
        weights = self._weights(probabilities)
        memory.means[:] = vector(mean, n, "mean")
        memory.covariances[:, :, :n] = _covariance(deviations, n)
        memory.coming[:] = 0.0 if inputs is None else vector(inputs, memory.coming.size, "inputs")
        memory.allowed[:] = self._mask(situation)
        memory.weights[:] = weights
        self._begin(self._handle, number(time, "time"))

    def allow(self, situation: str | None) -> None:
        """Leave the hypotheses of a situation from the last step on; if none of them was likely, they begin anew.

        Args:
            situation: Its name; None for all hypotheses.

        Raises:
            DoormanError: if there is no such situation.
        """
        self._memory.kept_allowed[self._newest] = self._mask(situation)

    def measure(self, name: str, time: float, reading: ArrayLike) -> Status:
        """Take a reading; the next step fuses it at its own time.

        Args:
            name: Of the measurement.
            time: At which it was true [s].
            reading: Its rows, (r,).

        Returns:
            `OK`, or why it is not taken. Whether it passes the gate is known after the step.

        Raises:
            DoormanError: if there is no such measurement, or its size does not fit.
        """
        if name not in self._measurements:
            raise DoormanError("unknown", field="measurement", given=name, allowed=", ".join(self._measurements))
        kind = self._measurements[name]
        size = self._sizes[kind]
        self._memory.reading[:size] = _rows(reading, size, name)
        return _STATUSES[self._store(self._handle, kind, float(time), size)]

    def step(self, time: float, inputs: ArrayLike = ()) -> Status:
        """Go on to a time, with all measurements that have come.

        Args:
            time: Now [s].
            inputs: What acts from now on, (m,).

        Returns:
            The worst that happened.

        Raises:
            DimensionError: if the number of inputs does not fit.
        """
        self._memory.coming[:] = _rows(inputs, self._memory.coming.size, "inputs")
        return _STATUSES[self._step(self._handle, float(time))]

    def estimate(self) -> FilterEstimate:
        """What is known at the time of the last step.

        Raises:
            DoormanError: if the filter does not run.
        """
        if not self.running:
            raise DoormanError("the filter does not run", field="filter", allowed="an estimate between start and loss")
        report, n = np.empty(self._size), self._memory.mean.size
        self._report(self._handle, report)
        mean, deviations = sealed(report[:n]), sealed(report[n : 2 * n])
        return FilterEstimate(self.time, report, mean, deviations, self._hypotheses, self._outputs)

    def acted(self, inputs: ArrayLike) -> None:
        """Say what acts since the last step, where it is known better than it was: an attitude that came late.

        Args:
            inputs: As in `step`, (m,).

        Raises:
            DoormanError: if their number does not fit, or one is not finite.
        """
        self._memory.kept_inputs[self._newest] = vector(inputs, self._memory.coming.size, "inputs")

    @property
    def log_likelihood(self) -> float:
        """Sum of the log densities of all fused measurements since the start, each given those before it."""
        return self._memory.progress.log_likelihood

    def score(self, name: str) -> MeasurementScore:
        """How a kind of measurement fared since the start.

        Args:
            name: Of the measurement.

        Raises:
            DoormanError: if there is no such measurement.
        """
        if name not in self._measurements:
            raise DoormanError("unknown", field="measurement", given=name, allowed=", ".join(self._measurements))
        kind, scores = self._measurements[name], self._memory.scores
        fused, innovation = int(scores.fused[kind]), scores.innovation.item(kind)
        return MeasurementScore(fused, int(scores.refused[kind]), innovation / fused if fused else math.nan)

    def _check_hypotheses(self, field: str, names: Any) -> None:
        unknown = [name for name in names if name not in self._hypotheses]
        if unknown:
            raise DoormanError(
                "unknown hypothesis",
                field=field,
                given=", ".join(map(str, unknown)),
                allowed=", ".join(self._hypotheses),
            )

    def _checked_situations(self, allowed: Mapping[str, Sequence[str]] | None) -> dict[str, tuple[str, ...]]:
        """Situations whose names are known, and that together allow every hypothesis."""
        if allowed is None:
            return {}
        for situation, names in allowed.items():
            self._check_hypotheses(f"allowed.{situation}", names)
            if not names:
                raise DoormanError("no hypothesis", field=f"allowed.{situation}", allowed=", ".join(self._hypotheses))
        some = [name for name in self._hypotheses if any(name in names for names in allowed.values())]
        idle = [name for name in self._hypotheses if name not in some]
        if idle:
            raise DoormanError(
                "no situation allows this hypothesis",
                field="hypotheses",
                given=", ".join(idle),
                allowed=", ".join(some),
            )
        return {situation: tuple(names) for situation, names in allowed.items()}

    def _mask(self, situation: str | None) -> Array:
        if situation is None:
            return np.ones(len(self._hypotheses))
        if situation not in self._allowed:
            raise DoormanError(
                "unknown", field="situation", given=situation, allowed=", ".join(self._allowed) or "None"
            )
        return np.array([float(name in self._allowed[situation]) for name in self._hypotheses])

    def _weights(self, probabilities: Mapping[str, float] | None) -> Array:
        if probabilities is None:
            return np.full(len(self._hypotheses), 1.0 / len(self._hypotheses))
        self._check_hypotheses("probabilities", probabilities)
        weights = np.array([number(probabilities.get(name, 0.0), name) for name in self._hypotheses])
        if weights.min() < 0.0 or not weights.sum() > 0.0:
            raise DoormanError("not probabilities", field="probabilities", given=dict(probabilities), allowed="0 to 1")
        return np.asarray(weights / weights.sum())


_STATUSES = tuple(Status)


def _rows(given: ArrayLike, size: int, field: str) -> Any:
    """Numbers of the right count, finite or not."""
    if type(given) is np.ndarray and given.dtype == np.float64 and given.shape == (size,):
        return given
    found = numbers(given, field)
    if found.shape != (size,) and not (size == 1 and found.size == 1):
        raise DimensionError("wrong shape", field=field, given=found.shape, allowed=f"({size},)")
    return found


def _covariance(given: ArrayLike, n: int) -> Array:
    """A covariance, or deviations squared on its diagonal."""
    found = numbers(given, "deviations")
    matrix = np.diag(found**2) if found.shape == (n,) else found
    if matrix.shape != (n, n) or not np.isfinite(matrix).all():
        raise DimensionError("not a covariance", field="deviations", given=found.shape, allowed=f"({n},) or ({n}, {n})")
    scale = np.abs(matrix).max()
    if np.abs(matrix - matrix.T).max() > _ROUNDING * scale or np.linalg.eigvalsh(matrix).min() < -_ROUNDING * scale:
        raise DimensionError("not a covariance", field="deviations", allowed="symmetric and positive")
    return np.asarray(0.5 * (matrix + matrix.T))
