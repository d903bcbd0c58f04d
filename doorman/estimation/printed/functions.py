"""One function of a filter, ready to be printed: values, then the nonzeros of slopes, then those of a noise's lower half."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from doorman.ocp.kernels.printed.printing import printed

Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Function:
    """Expressions of x, u, p and h."""

    name: str
    values: Sequence[Any]
    """Columns."""
    slopes: Any
    """Jacobian of the first column with respect to x."""
    noise: Any = None
    """Q; only of predictions."""
    equalities: int = 0
    """How many of the first rows are zero."""

    @property
    def rows(self) -> int:
        """Number of rows of the first column."""
        return int(self.slopes.shape[0])

    @property
    def size(self) -> int:
        """How many numbers it writes."""
        noise = 0 if self.noise is None else ca.tril(self.noise).nnz()
        return int(sum(each.numel() for each in self.values) + self.slopes.nnz() + noise)

    def places(self) -> tuple[list[int], list[int]]:
        """Where each row ends among the nonzeros, from 0 on, and the column of each."""
        columns, rows = self.slopes.T.sparsity().get_triplet()  # CasADi goes down the columns
        return np.cumsum([0, *np.bincount(rows, minlength=self.rows)]).tolist(), columns

    def noise_places(self) -> list[int]:
        """Row and column of each nonzero in turn, after their count."""
        rows, columns = ca.tril(self.noise).sparsity().get_triplet()
        return [len(rows), *(index for pair in zip(rows, columns, strict=True) for index in pair)]

    def text(self, symbols: dict[str, Any]) -> str:
        """The kernel."""
        results = [ca.densify(each) for each in self.values] + [self.slopes.T]
        results += [] if self.noise is None else [ca.tril(self.noise)]
        offsets = np.cumsum([0, *(each.nnz() for each in results)]).tolist()
        lines = printed(
            self.name, symbols, results, lambda symbol, i: "h" if symbol == "h" else f"{symbol}[{i}]",
            lambda k, i, value: f"out[{offsets[k] + i}] = {value}",
        )  # fmt: skip
        return f"@straight\ndef {self.name}(x, u, p, h, out):\n    " + "\n    ".join(lines)


def padded(tables: Sequence[Sequence[int]]) -> Indices:
    """Tables of indices, one a row, filled with 0."""
    filled = np.zeros((len(tables), max(1, *(len(table) for table in tables), 0)), dtype=np.int64)
    for row, table in enumerate(tables):
        filled[row, : len(table)] = table
    return filled
