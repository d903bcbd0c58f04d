"""The Python of docs/optimal_control.md as a module: its kernels need a file."""

from __future__ import annotations

import functools
import importlib.util
import re
import sys
import tempfile
from pathlib import Path
from types import ModuleType

PAGE = Path(__file__).parents[3] / "docs" / "optimal_control.md"


@functools.cache
def tutorial(blocks_of_it: int | None = None) -> ModuleType:
    """The page's blocks, or its first ones, run one after the other as a reader would."""
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)[
        :blocks_of_it
    ]
    path = Path(tempfile.mkdtemp(prefix="tutorial-")) / f"optimal_control_page_{len(blocks)}.py"
    path.write_text("\n".join(blocks), encoding="utf-8")
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module  # numba's cache finds the model's type by this name
    spec.loader.exec_module(module)
    return module
