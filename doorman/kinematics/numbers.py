"""Named numbers of a task in one vector: symbols stand for them, kernels read them, a change compiles nothing."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from doorman.arrays import Array
from doorman.exceptions import DimensionError


class Numbers:
    """Numbers and vectors by name, in a fixed order; read-only."""

    def __init__(self, entries: Mapping[str, ArrayLike]) -> None:
        parts = {name: np.atleast_1d(np.asarray(value, dtype=np.float64)).ravel() for name, value in entries.items()}
        self.sizes = {name: len(part) for name, part in parts.items()}
        """How many numbers a name stands for."""
        self.vector: Array = np.concatenate([*parts.values(), np.zeros(0)])
        """All of them, shape (np,)."""
        self.vector.flags.writeable = False
        ends = np.cumsum([0, *self.sizes.values()])
        self._places = {name: slice(int(ends[i]), int(ends[i + 1])) for i, name in enumerate(self.sizes)}

    def __getitem__(self, name: str) -> Array:
        return self.vector[self.place(name)]

    def named(self, vector: ArrayLike) -> dict[str, Array]:
        """Other numbers in the same order, by name."""
        other = np.asarray(vector, dtype=np.float64)
        return {name: other[place] for name, place in self._places.items()}

    def one(self, name: str) -> float:
        """The number of a name that stands for one."""
        return float(self.vector.item(self.place(name).start))

    def replaced(self, changes: Mapping[str, ArrayLike]) -> Numbers:
        """Numbers with others for some of the names."""
        changed = object.__new__(Numbers)
        changed.sizes, changed._places, changed.vector = self.sizes, self._places, self.vector.copy()
        for name, value in changes.items():
            place = self.place(name)
            if type(value) is float and self.sizes[name] == 1:  # most are, and are quickly written
                changed.vector[place.start] = value
                continue
            if type(value) is np.ndarray and value.shape == (self.sizes[name],):
                changed.vector[place] = value
                continue
            try:
                changed.vector[place] = np.ravel(np.asarray(value, dtype=np.float64))
            except ValueError as error:
                raise DimensionError(
                    "wrong count of numbers", field=name, given=np.size(value), allowed=str(self.sizes[name])
                ) from error
        changed.vector.flags.writeable = False
        return changed

    def and_also(self, entries: Mapping[str, ArrayLike]) -> Numbers:
        """These numbers, with further names behind them."""
        return Numbers({**{name: self[name] for name in self.sizes}, **entries})

    def place(self, name: str) -> slice:
        """Where in the vector a name's numbers stand."""
        try:
            return self._places[name]
        except KeyError:
            raise DimensionError("no such number", field=name, allowed=", ".join(self.sizes)) from None
