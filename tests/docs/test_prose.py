"""Sentences of the pages are short: none has more than 35 words, and a page's sentences have 20 on average."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md", "urdf/README.md")),
    *sorted(path for path in DOCS.rglob("*.md") if DOCS / "api" not in path.parents),
]
LONGEST, AVERAGE = 35, 20.0
LABEL = 3
"""Up to this many words are a label, such as a cell of a table: it does not pull the average down."""

FENCE = re.compile(r"^[ ]*(```|~~~|:::).*?^[ ]*\1[`~:]*[ ]*$", re.MULTILINE | re.DOTALL)
APART = re.compile(r"\$\$.*?\$\$|<!--.*?-->", re.DOTALL)
ITEM = re.compile(r"^\s*(?:[-*+]|\d+[.)])\s+")
UNDERLINE = re.compile(r"\|[\s:|-]+\|?")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|cf|vs|etc|Fig|Figs|Eq|Eqs|No|approx)\.(?=\s)")
END = re.compile(r"(?<=[.!?])[)\]*_”\"]*\s+")


def paragraphs(text: str) -> Iterator[str]:
    """Paragraphs, list items and table cells of a page, without headings, code blocks and formulas of their own."""
    lines: list[str] = []
    for line in [*APART.sub(" ", FENCE.sub("\n", text)).splitlines(), ""]:
        row = line.lstrip().startswith("|")
        if lines and (row or not line.strip() or line.startswith("#") or ITEM.match(line)):
            yield " ".join(lines)
            lines = []
        if row and not UNDERLINE.fullmatch(line.strip()):
            yield from re.sub(r"`+[^`]*`+", "code", line).replace(r"\|", "/").strip().strip("|").split("|")
        elif not row and line.strip() and not line.startswith("#"):
            lines.append(ITEM.sub("", line, count=1).strip().removeprefix("> "))


def plain(paragraph: str) -> str:
    """A paragraph as it is read: a link is its text; code and a formula are one word each; a picture is none."""
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", paragraph)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    text = re.sub(r"`+[^`]*`+", "code", text)
    text = re.sub(r"\$[^$]*\$", "formula", text)
    return ABBREVIATION.sub(r"\1", text)


def sentences(text: str) -> list[tuple[int, str]]:
    """Number of words and text of every sentence; only a full stop, an exclamation or a question mark ends one."""
    found = [sentence for paragraph in paragraphs(text) for sentence in END.split(plain(paragraph))]
    counted = [(sum(1 for word in sentence.split() if re.search(r"\w", word)), sentence) for sentence in found]
    return [(words, sentence) for words, sentence in counted if words]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_sentences_are_short(page):
    found = sentences(page.read_text(encoding="utf-8"))
    long = [f"{words} words: {sentence}" for words, sentence in found if words > LONGEST]
    assert not long, "\n".join(long)
    lengths = [words for words, _ in found if words > LABEL]
    assert sum(lengths) <= AVERAGE * len(lengths), f"{sum(lengths) / len(lengths):.1f} words on average"
