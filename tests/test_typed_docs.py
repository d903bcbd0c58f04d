"""The Python of README, docs and the examples' pages is right by `mypy --strict`: a page's blocks are one program."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parent.parent
CODE = re.compile(r"```(?:python|\{code-cell\}.*)")
CHECKED = re.compile(r"(.+)\.py:(\d+): (error: .+)")


def program(page: str) -> str:
    """Code of a page, every line where it stands in the page: what mypy says of a line is true for both."""
    lines: list[str] = []
    inside = False
    for line in page.splitlines():
        opens = not inside and CODE.fullmatch(line)
        closes = inside and line == "```"
        lines.append(line if inside and not closes else "")
        inside = not closes if inside else bool(opens)
    return "\n".join(lines) + "\n"


def complaints(pages: dict[str, str], folder: Path) -> list[str]:
    """What mypy says of pages by name, each with the page's line."""
    files = {re.sub(r"\W", "_", name): name for name in pages}
    for stem, name in files.items():
        (folder / f"{stem}.py").write_text(program(pages[name]), encoding="utf-8")
    ran = subprocess.run(
        [sys.executable, "-m", "mypy", "--no-error-summary", "--hide-error-context", "--no-pretty", str(folder)],
        cwd=ROOT, capture_output=True, text=True, timeout=600, check=False,
    )  # fmt: skip
    found = [CHECKED.fullmatch(line) for line in ran.stdout.splitlines() if ": note: " not in line]
    assert ran.returncode in (0, 1) and all(found), ran.stdout + ran.stderr
    return [f"{files[Path(one[1]).name]}:{one[2]}: {one[3]}" for one in found if one]


def pages_with_code() -> dict[str, str]:
    paths = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "examples").rglob("*.md"))]
    pages = {str(path.relative_to(ROOT)): path.read_text(encoding="utf-8") for path in paths}
    return {name: text for name, text in pages.items() if program(text).strip()}


def test_the_python_of_the_pages_has_the_right_types(tmp_path: Path) -> None:
    pages = pages_with_code()
    assert "README.md" in pages and "docs/tutorials/push.md" in pages
    wrong = (
        "A page:\n\n```python\nimport doorman\n```\n\nand so on:\n\n```{code-cell} python\ndoorman.Planner(3)\n```\n"
    )
    *found, last = complaints({"wrong.md": wrong, **pages}, tmp_path)
    assert not found, "\n".join(found)
    assert last.startswith("wrong.md:10: error: Argument 1"), last
