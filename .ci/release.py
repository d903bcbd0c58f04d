#!/usr/bin/env python3
"""What would keep a release from being made: another version somewhere, no section in the changelog, wrong distributions.

python .ci/release.py DIST [TAG]: DIST holds wheel and sdist; with a tag, the changelog's first section has to be this release.
"""

from __future__ import annotations

import re
import sys
import tarfile
import tomllib
import zipfile
from pathlib import Path

from packaging.metadata import Metadata

ROOT = Path(__file__).resolve().parent.parent
LONGEST = 50
"""Lines of a release in the changelog: two screens."""
HEADING = re.compile(r"^## \[(.+?)\](?: - (\d{4}-\d{2}-\d{2}))?\n", re.MULTILINE)


def versions(root: Path) -> dict[str, str]:
    """The version by the file that says it."""
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    lines = {"doorman/__init__.py": r'^__version__ = "(.+)"$', "CITATION.cff": r"^version: (.+)$"}
    found = {
        name: re.search(line, (root / name).read_text(encoding="utf-8"), re.MULTILINE) for name, line in lines.items()
    }
    return {"pyproject.toml": project} | {name: line[1] if line else "none" for name, line in found.items()}


def sections(changelog: str) -> dict[str, tuple[str | None, list[str]]]:
    """Date and lines of every section of the changelog by its version, the newest first."""
    _, *parts = HEADING.split(changelog)
    return {
        version: (date, body.strip().splitlines())
        for version, date, body in zip(parts[::3], parts[1::3], parts[2::3], strict=True)
    }


def wrong_in_source(root: Path, tag: str = "") -> list[str]:
    """What is wrong with versions and changelog."""
    said = versions(root)
    version = said["pyproject.toml"]
    found = [
        f"{name}: version {other}, but pyproject.toml has {version}" for name, other in said.items() if other != version
    ]
    if tag and tag != f"v{version}":
        found.append(f"the tag is {tag}, but the version is {version}: expected v{version}")
    written = sections((root / "CHANGELOG.md").read_text(encoding="utf-8"))
    date, lines = written.get(version, (None, []))
    if not lines:
        found.append(f"CHANGELOG.md: no section [{version}] with text")
    elif date is None:
        found.append(f"CHANGELOG.md: [{version}] has no date: expected '## [{version}] - YYYY-MM-DD'")
    found += [
        f"CHANGELOG.md: [{name}] has {len(text)} lines, allowed: {LONGEST}"
        for name, (_, text) in written.items()
        if len(text) > LONGEST
    ]
    if tag and next(iter(written), None) != version:
        found.append(f"CHANGELOG.md: begins with [{next(iter(written), '')}], but [{version}] is to be released")
    return found


def wrong_in_distributions(dist: Path, version: str) -> list[str]:
    """What is wrong with wheel and sdist."""
    stem = f"doorman_uam-{version}"
    expected = {f"{stem}-py3-none-any.whl", f"{stem}.tar.gz"}
    there = {path.name for path in dist.iterdir()}
    if there != expected:
        return [f"{dist} holds {sorted(there)}, expected {sorted(expected)}"]
    with zipfile.ZipFile(dist / f"{stem}-py3-none-any.whl") as wheel:
        texts = {"wheel": wheel.read(f"{stem}.dist-info/METADATA")}
    with tarfile.open(dist / f"{stem}.tar.gz") as sdist:
        member = sdist.extractfile(f"{stem}/PKG-INFO")
        assert member is not None
        texts["sdist"] = member.read()
    found = []
    for name, text in texts.items():
        try:
            metadata = Metadata.from_email(text, validate=True)  # as the package index does
        except ExceptionGroup as group:
            found += [f"{name}: {error}" for error in group.exceptions]
            continue
        if not metadata.description or metadata.description_content_type != "text/markdown":
            found.append(f"{name}: no description in Markdown")
    return found


if __name__ == "__main__":
    place, *given = sys.argv[1:]
    wrong = wrong_in_source(ROOT, *given)
    wrong += wrong_in_distributions(Path(place), versions(ROOT)["pyproject.toml"])
    print("\n".join(wrong) or f"{', '.join(sorted(path.name for path in Path(place).iterdir()))}: can be released")
    sys.exit(bool(wrong))
