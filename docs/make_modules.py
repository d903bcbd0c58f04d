"""Writes docs/modules.md: every module of doorman with the first sentence of its docstring, in the order of the import layers.

Usage: python docs/make_modules.py
"""

from __future__ import annotations

import ast
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "modules.md"
HEAD = """# Modules

`docs/make_modules.py` writes this page from the modules' docstrings. Imports run one way, from the bottom of the page to the top:
a package uses what stands above it on this page. `lint-imports` checks this by the layers in `pyproject.toml`.
"""


def page() -> str:
    """The page, as Markdown."""
    parts = [HEAD]
    single = [ROOT / "doorman" / f"{name}.py" for name in layers() if (ROOT / "doorman" / f"{name}.py").exists()]
    parts.append(_table("Single modules", "`doorman/`", single))
    for name in layers():
        folder = ROOT / "doorman" / name
        if folder.is_dir():
            parts += [_package(each) for each in (folder, *sorted(path for path in folder.rglob("*") if path.is_dir()))]
    return "\n".join(part for part in parts if part)


def layers() -> list[str]:
    """Packages and modules below doorman, from what knows least to what knows most.

    Raises:
        SystemExit: if a package or module stands in no layer.
    """
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    rows = next(each["layers"] for each in contracts if each["name"] == "Imports run one way")
    named = [name.strip().removeprefix("doorman.") for row in reversed(rows) for name in sorted(row.split("|"))]
    there = {
        path.stem for path in (ROOT / "doorman").iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    if missing := sorted(there - set(named) - {"__init__", "__main__"}):
        raise SystemExit(f"pyproject.toml: no layer holds {', '.join(missing)}")
    return named


def _package(folder: Path) -> str:
    files = sorted(path for path in folder.glob("*.py") if path.name != "__init__.py")
    if not files:
        return ""
    return _table(str(folder.relative_to(ROOT / "doorman")), _summary(folder / "__init__.py"), files)


def _table(title: str, words: str, files: list[Path]) -> str:
    lines = [f"## {title}", "", words, "", "| module | what |", "| --- | --- |"]
    lines += [f"| `{path.relative_to(ROOT / 'doorman')}` | {_summary(path)} |" for path in files]
    return "\n".join([*lines, ""])


def _summary(path: Path) -> str:
    """First paragraph of a module's docstring, on one line."""
    words = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) if path.exists() else None
    if not words:
        raise SystemExit(f"{path}: no docstring")
    return " ".join(words.split("\n\n")[0].split()).replace("|", "\\|")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(f"written: {PAGE.relative_to(ROOT)}")
