"""The documentation builds without a warning, and holds every public name, every formula and every link."""

from __future__ import annotations

import html
import importlib
import inspect
import os
import pkgutil
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from latex2mathml.converter import convert
from sphinx.util.inventory import InventoryFile

import doorman

pytestmark = pytest.mark.docs

ROOT = Path(__file__).parents[2]
_INSIDE = ("doorman.cli", "doorman.compilation", "doorman.rig.emulators", "doorman.summary")
"""Packages that only doorman itself, and its tests, import from."""
PACKAGES = [module.name for module in pkgutil.walk_packages(doorman.__path__, "doorman.") if module.ispkg]


def build(folder: Path, *options: str) -> Path:
    """Build all pages; a warning is an error."""
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-c", "docs", *options,
               "-d", str(folder / "trees"), ".", str(folder / "html")]  # fmt: skip
    ran = subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, timeout=900, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert ran.returncode == 0, ran.stderr  # a Jupyter kernel may grumble as it is shut down
    return folder / "html"


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """All pages, with the tutorials executed."""
    return build(tmp_path_factory.mktemp("docs"))


def exported(package: str) -> list[str]:
    """Names that a package brings in from its modules."""
    module = importlib.import_module(package)
    if hasattr(module, "__all__"):
        return list(module.__all__)
    imports = re.findall(
        rf"^from {re.escape(package)}\.\w+ import (\w+) as \1$", inspect.getsource(module), re.MULTILINE
    )
    return list(imports)


@pytest.mark.parametrize("package", ["doorman", *(name for name in PACKAGES if not name.startswith(_INSIDE))])
def test_every_public_name_is_in_the_reference(built, package):
    with (built / "objects.inv").open("rb") as stream:
        inventory = InventoryFile.load(stream, "", lambda base, path: base + path)
    known = {name for kind, names in inventory.items() if kind.startswith("py:") for name in names}
    for name in exported(package):
        thing = getattr(importlib.import_module(package), name)
        home = f"{getattr(thing, '__module__', '')}.{getattr(thing, '__qualname__', '')}"
        data = [one for one in known if one.startswith(f"{package}.") and one.endswith(f".{name}")]
        assert data or home in known or f"doorman.{name}" in known, name


def test_every_page_is_built(built):
    pages = ["README.md", "CHANGELOG.md", "urdf/README.md"]
    pages += [str(path.relative_to(ROOT)) for path in (ROOT / "docs").rglob("*.md")]
    for page in pages:
        assert (built / page).with_suffix(".html").is_file(), page
    assert "docs/index.html" in (built / "index.html").read_text(encoding="utf-8")


def test_formulas_are_mathml_that_says_the_same(built):
    text = (built / "docs" / "theory.html").read_text(encoding="utf-8")
    formulas = re.findall(r"<math.*?</math>", text, re.DOTALL)
    source = (ROOT / "docs" / "theory.md").read_text(encoding="utf-8")
    blocks = re.findall(r"\$\$.+?\$\$", source, re.DOTALL)
    inline = re.findall(r"\$[^$]+\$", re.sub(r"\$\$.+?\$\$", "", source, flags=re.DOTALL))
    assert len(formulas) == len(blocks) + len(inline)
    text_of_page = (built / "docs" / "push.html").read_text(encoding="utf-8")
    assert convert(r"a = \eta\hat\tau/I") in text_of_page
    assert "<mfrac><mn>1</mn><mn>2</mn></mfrac>" in text_of_page
    for formula in formulas:
        tree = ElementTree.fromstring(re.sub(r"&(?!lt|gt|amp)\w+;", lambda entity: html.unescape(entity[0]), formula))
        assert "".join(tree.itertext()).strip()
    assert "$" not in re.sub(r"<[^>]+>", "", text.split('role="main"')[1].split("<footer")[0])


def test_tutorials_are_executed(built: Path) -> None:
    tutorials = sorted((ROOT / "docs" / "tutorials").glob("*.md"))
    assert len(tutorials) == 7
    for tutorial in tutorials:
        page = (built / "docs" / "tutorials" / f"{tutorial.stem}.html").read_text(encoding="utf-8")
        cells = tutorial.read_text(encoding="utf-8").count("```{code-cell}")
        assert page.count("cell_input") >= cells >= 2, tutorial.stem
        assert page.count("cell_output") >= cells // 2, tutorial.stem
        assert "Traceback" not in page, tutorial.stem
