"""Names: the distribution is `doorman-uam`; nobody is told to install `doorman`, which is another project's on an index."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]
SUFFIXES = {".py", ".md", ".toml", ".cff", ".txt", ".ipynb", ".yaml", ".yml", ".cfg", ".js", ".html", ".urdf", ""}
TOOLS = r"(?:pip3?|pipx|uv|uvx|poetry|pdm|rye|hatch|conda|mamba|micromamba|pixi|easy_install|python3? -m pip)"
VERBS = r"(?:install|add|run|wheel|download|inject|sync|upgrade)"
PACKAGE = r"doorman(?:[-_.]uam)?(?:\[[\w, -]*\])?(?:\s*[=<>~!]=?=?\s*[\w.*]+)?"
RULES = {
    "an installer and its argument": re.compile(
        rf"\b{TOOLS}[ \t](?:[^\n&;|]*[ \t])?{VERBS}\b(?:(?!\.\s)[^\n&;|)])*?[ \t'\"`=]{PACKAGE}(?=[ \t'\"`,;.)]|$)",
        re.MULTILINE,
    ),
    "uvx": re.compile(rf"\b(?:uvx|pipx run)\s+['\"]?{PACKAGE}"),
    "extras of the other project": re.compile(r"(?<![\w./-])doorman\[[a-z]+(?:,\s*[a-z]+)*\]"),
    "its page on an index": re.compile(r"://[\w.]+/(?:project|simple|p)/doorman(?![-\w])", re.IGNORECASE),
    "its metadata": re.compile(r"(?:version|distribution|metadata|files|requires)\(\s*['\"]doorman['\"]"),
}


def told(text: str) -> list[str]:
    """What of a text tells somebody to install the wrong thing, or asks for its metadata."""
    joined = re.sub(r"\\\n\s*", " ", text)
    return [f"{name}: {found[0]}" for name, rule in RULES.items() for found in rule.finditer(joined)]


def texts() -> list[Path]:
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True)
    names = listed.stdout.splitlines() if listed.returncode == 0 else []
    paths = [ROOT / name for name in names] or [path for path in ROOT.rglob("*") if ".venv" not in path.parts]
    return [path for path in paths if path.suffix in SUFFIXES and path.is_file() and path != Path(__file__)]


def test_no_text_tells_anybody_to_install_the_other_project():
    paths = texts()
    assert {ROOT / name for name in ("README.md", "Makefile", "doorman/cli/app.py", "docs/campaign.md")} <= set(paths)
    found = {str(path.relative_to(ROOT)): words for path in paths if (words := told(path.read_text(encoding="utf-8")))}
    assert found == {}
