"""Sphinx: the pages of docs/, README and changelog as they stand, and the library's reference from its docstrings.

The source directory is the repository, so that links among the pages are the same here as where the files are read raw.
"""

from __future__ import annotations

import atexit
import logging
import os
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util.logging import getLogger

import doorman

project = "doorman"
author = "The doorman developers"
version = release = doorman.__version__
copyright = author

root_doc = "docs/index"
include_patterns = [
    "README.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    "CHANGELOG.md",
    "examples/README.md",
    "examples/*.ipynb",
    "urdf/README.md",
    "docs/**.md",
]
exclude_patterns = [".*", "build", "doorman", "tests", "benchmarks"]

_profile = tempfile.mkdtemp()
atexit.register(shutil.rmtree, _profile, ignore_errors=True)
os.environ["IPYTHONDIR"] = _profile
os.environ["PYDEVD_DISABLE_FILE_VALIDATION"] = "1"
_settings = Path(_profile) / "profile_default" / "ipython_kernel_config.py"
_settings.parent.mkdir()
_settings.write_text("c.IPKernelApp.log_level = 40\n")  # kernels warn of things that do not matter for the tutorials
logging.getLogger("traitlets").setLevel(logging.WARNING)

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3

nb_execution_mode = "force"  # the tutorials, with the library as it is now
nb_execution_in_temp = True
nb_execution_timeout = 600
nb_execution_raise_on_error = True

html_theme = "furo"
html_title = f"doorman {release}"
html_math_renderer = "mathml"
html_show_copyright = False

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {
    name: name for name in ("Array", "ArrayLike", "Function", "Integrator", "OnProgress", "Listener")
}
"""Names that signatures keep: what they stand for fills lines."""
autodoc_default_options = {"members": True, "undoc-members": True, "show-inheritance": True}
default_role = "code"
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

_CONTENTS = """

```{toctree}
:hidden:
:glob:
:caption: Guide

/README
*
```

```{toctree}
:hidden:
:caption: Tutorials

tutorials/open_the_door
tutorials/own_door
tutorials/constraints
tutorials/pendulum
tutorials/flight_script
tutorials/push
tutorials/campaign
```

```{toctree}
:hidden:
:glob:
:caption: Gallery

gallery/*
```

```{toctree}
:hidden:
:glob:
:caption: How to

how-to/*
/examples/README
/examples/plot_a_flight
```

```{toctree}
:hidden:
:glob:
:caption: Decisions

decisions/*
```

```{toctree}
:hidden:
:glob:
:caption: Vehicle and door

hardware/*
/urdf/README
```

```{toctree}
:hidden:
:glob:
:caption: Library

api/*
```

```{toctree}
:hidden:
:caption: Project

/CONTRIBUTING
/SECURITY
/CHANGELOG
```
"""
"""Table of contents; added to the index here, since it would be noise where the page is read raw."""

_PLAIN = ("attribute", "data")
"""What has docstrings of one sentence, in which napoleon would take a colon for the end of a type."""

_kept: dict[str, list[str]] = {}
"""Their docstrings, while napoleon is at work."""

_EQUATION = "overflow-x: auto; overflow-y: hidden; padding: 0.4em 0"
"""Style of a formula that stands by itself."""

_ENTRY = """<!doctype html>
<meta charset="utf-8">
<meta http-equiv="refresh" content="0; url=docs/index.html">
<title>doorman</title>
"""


def setup(app: Sphinx) -> None:
    """Register what no extension brings."""
    app.add_html_math_renderer("mathml", (_visit_math, None), (_visit_equation, None))
    app.connect("source-read", _add_contents)
    app.connect("autodoc-process-docstring", _before_napoleon, priority=400)
    app.connect("autodoc-process-docstring", _after_napoleon, priority=600)
    app.connect("build-finished", _write_entry)


def _add_contents(_app: Sphinx, page: str, text: list[str]) -> None:
    if page == root_doc:
        text[0] += _CONTENTS
    elif page == "docs/scenario":
        text[0] = re.sub(r"^## `\[([\w.]+)\]`\n(?:(?!^## ).*\n)*", _indexed, text[0], flags=re.MULTILINE)


def _indexed(section: re.Match[str]) -> str:
    """A table of a scenario with an entry of the index for every key, by which a search for `door mass` finds it."""
    keys = re.findall(r"^\| `(\w+)` \|", section[0], re.MULTILINE)
    heading, rest = section[0].split("\n", 1)
    words = [f"{section[1]} {key}".replace(".", " ").replace("_", " ") for key in keys]
    entries = "".join(f"   single: {each}\n" for each in words)
    return f"{heading}\n\n```{{eval-rst}}\n.. index::\n{entries}```\n\n{rest}" if keys else section[0]


def _before_napoleon(_app: Sphinx, what: str, name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Bars are absolute values, no substitutions; an attribute's colon ends no type."""
    for i, line in enumerate(lines):
        parts = re.split(r"(:\w+:`[^`]*`|``.*?``|`[^`]*`)", line)  # every other one is code or a formula
        parts[::2] = [part.replace("|", r"\|") for part in parts[::2]]
        lines[i] = "".join(parts)
    if what in _PLAIN:
        _kept[name] = lines[:]
        lines.clear()


def _after_napoleon(_app: Sphinx, what: str, name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    if what in _PLAIN:
        lines[:] = _kept.pop(name)


def _visit_math(translator: Any, node: nodes.math) -> None:
    translator.body.append(_formula(node, "inline"))
    raise nodes.SkipNode


def _visit_equation(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(f'<div style="{_EQUATION}">{_formula(node, "block")}</div>\n')
    raise nodes.SkipNode


def _formula(node: nodes.Element, display: str) -> str:
    """A formula as MathML: browsers draw it by themselves, without a network."""
    formula = convert(" ".join(node.astext().split()), display=display)
    unknown = re.findall(r"\\\w+", formula)
    if unknown:
        getLogger(__name__).warning("not known in formulas: %s", ", ".join(unknown), location=node)
    return formula


def _write_entry(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        (Path(app.outdir) / "index.html").write_text(_ENTRY, encoding="utf-8")
        videos = Path("docs") / "pictures" / "gallery"  # raw HTML names them, so that nobody else copies them
        shutil.copytree(Path(app.srcdir) / videos, Path(app.outdir) / videos, dirs_exist_ok=True)
