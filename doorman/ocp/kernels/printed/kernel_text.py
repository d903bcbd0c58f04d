"""Text of kernels that compute expressions, of one node or of nodes side by side."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from doorman.ocp.kernels.printed.printing import Write, printed
from doorman.ocp.problem.expressions import Expressions


class KernelText:
    """Kernels of a problem's expressions.

    Args:
        expressions: The expressions.
        more: Further symbols, arguments of that name.
    """

    def __init__(self, expressions: Expressions, **more: Any) -> None:
        self._symbols = {
            "x": expressions.x, "u": expressions.u, "h": expressions.time_step, "p": expressions.parameters,
            "q": expressions.node_parameters, **more,
        }  # fmt: skip
        self.has_nodes = not expressions.node_parameters.is_empty()

    def formula(self, name: str, arguments: str, results: Sequence[Any], write: Write, returns: str = "") -> str:
        """Straight lines of one node."""
        places = {"h": "model.time_step", "p": "model.parameters[{}]", "q": "model.q[{}]"}
        lines = printed(
            name, self._symbols, results, lambda symbol, i: places.get(symbol, symbol + "[{}]").format(i), write
        )
        return f"@straight\ndef {name}({arguments}){returns}:\n    " + "\n    ".join(lines)

    def lanes(self, name: str, arguments: str, results: Sequence[Any]) -> str:
        """Straight lines of nodes side by side: the nonzeros of all results, one after the other."""
        offsets = [sum(result.nnz() for result in results[:k]) for k in range(len(results))]
        places = {"h": "model.time_step", "p": "model.parameters[{}]"}

        def read(symbol: str, i: int) -> str:
            return places[symbol].format(i) if symbol in places else f"get({symbol}, {i}, WIDTH)"

        def write(k: int, i: int, value: str) -> str:
            return f"put(out, {offsets[k] + i}, zero(WIDTH) + {value})"

        lines = printed(name, self._symbols, results, read, write)
        return f"@straight\ndef {name}({arguments}):\n    " + "\n    ".join(lines)

    def implemented(self, name: str, text: str) -> str:
        """A kernel's text as that of one of the functions of a model."""
        owners = ("Model", "Node") if self.has_nodes else ("Model",)
        return "".join(f"@functions.implement(functions.{name}, {owner})\n" for owner in owners) + text

    def node(self, name: str, arguments: str, results: Sequence[Any], write: Write, returns: str = "") -> str:
        """One of the functions of a model, of straight lines."""
        return self.implemented(name, self.formula(name, arguments, results, write, returns))

    def around(
        self, name: str, arguments: str, results: Sequence[Any], write: Write, before: str, after: Sequence[str] = ()
    ) -> str:
        """One with lines before and after that are not straight."""
        formula = self.formula(f"{name}_formula", arguments, results, write)
        body = "\n    ".join([before, f"{name}_formula({arguments})", *after])
        return f"{formula}\n\n\n" + self.implemented(name, f"@kernel\ndef {name}({arguments}):\n    {body}")


def places(matrix: Any) -> list[tuple[int, int]]:
    """Row and column of every nonzero, in CasADi's order."""
    return list(zip(*matrix.sparsity().get_triplet(), strict=True))


def tables(name: str, matrix: Any) -> str:
    """Rows and columns of the nonzeros as constants of a module."""
    found = places(matrix)
    return f"{name}_ROWS = {indices([row for row, _ in found])}\n{name}_COLUMNS = {indices([column for _, column in found])}"


def indices(values: Sequence[int]) -> str:
    """A table of indices."""
    return f"np.array({list(values)}, dtype=np.int64)"
