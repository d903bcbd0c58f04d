"""How many kernels there are in this process: the bound of what a run may have to compile."""

from __future__ import annotations

from doorman.compilation import cached_kernels


def known_kernels() -> int:
    """Kernels that modules and printed problems have brought so far; a run needs most of them, each for its arguments."""
    return len(cached_kernels._kernels)
