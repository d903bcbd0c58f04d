"""acados' renderer of templates, t_renderer, by the wheel of the same engine: the binary itself is on no package index."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import teraplate

VERSION = "0.2.1"
"""Of t_renderer whose arguments this takes: acados asks for it."""


def main() -> None:
    """t_renderer GLOB TEMPLATE JSON OUT."""
    if sys.argv[1:] == ["--version"]:
        print(f"t_renderer {VERSION}")
        return
    glob, template, numbers, out = sys.argv[1:]
    context = json.loads(Path(numbers).read_text(encoding="utf-8"))
    Path(out).write_text(teraplate.TeraEngine(glob).render(template, context), encoding="utf-8")


def renderer(folder: Path) -> Path:
    """Write a program that acados can call in place of its own.

    Args:
        folder: Where to.

    Returns:
        Its path.
    """
    path = folder.absolute() / "t_renderer"
    path.write_text(f"#!{sys.executable}\nfrom suite.tera import main\n\nmain()\n", encoding="utf-8")
    path.chmod(0o755)
    return path
