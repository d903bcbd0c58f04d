"""A URDF as XML, read within bounds: what a library would crash on, or take for ever over, never reaches it."""

from __future__ import annotations

import importlib.util
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from doorman.bounds import LARGEST_TEXT, read_bytes
from doorman.exceptions import UrdfError

LARGEST_FILE = LARGEST_TEXT
MOST_LINKS = 1000
MOST_ELEMENTS = 100_000
DEEPEST = 100
"""Elements inside each other, the root included."""
MOST_ATTRIBUTES = 64
"""An element's largest number of attributes: libraries need the square of them."""
LONGEST_ATTRIBUTE = 4096
"""Characters of a name, a text or a list of numbers."""
_PREFIX = re.compile(rb"<([A-Za-z_][A-Za-z0-9_.-]{0,40}):")
"""Of a tag that another program reads."""
_HELD: ContextVar[dict[Path, bytes] | None] = ContextVar("urdfs", default=None)
"""What `each_file_once` has read so far."""


@contextmanager
def each_file_once() -> Iterator[None]:
    """Read every URDF once inside: all that is made of a file sees the same bytes, even if it is written meanwhile."""
    token = _HELD.set(_HELD.get() or {})
    try:
        yield
    finally:
        _HELD.reset(token)


def parse_document(path: Path, content: bytes) -> ElementTree.Element:
    """Root element of XML of bounded depth and number of elements; tags with a prefix of another program are read over."""
    parser = ElementTree.XMLParser(target=_Builder(path))  # noqa: S314  # the builder refuses entities
    try:
        parser.feed(content)
        root: ElementTree.Element = parser.close()
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # the last two: an encoding that Python lacks
        if "unbound prefix" in str(error):
            if b"<xacro:" in content:
                raise _xacro(path) from error
            if (declared := _with_prefixes(content)) != content:
                return parse_document(path, declared)
        raise UrdfError(
            "not well-formed XML", file=path, field="XML", given=str(error), allowed="XML with <robot> as root element"
        ) from error
    return root


def read_content(path: Path) -> bytes:
    """Bytes of a file of bounded size."""
    held = _HELD.get()
    if held is not None and path in held:
        return held[path]
    if not path.is_file():
        raise UrdfError("no such URDF file", file=path, field="file", given=str(path), allowed="an existing file")
    content = read_bytes(path, LARGEST_FILE, UrdfError)
    if path.suffix == ".xacro" and importlib.util.find_spec("xacro") is not None:
        content = _expanded(path)
    if held is not None:
        held[path] = content
    return content


class _Builder(ElementTree.TreeBuilder):
    """Builds the tree, and stops where a bound is passed."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._path = path
        self._open: list[str] = []
        self._elements = self._links = 0

    def doctype(self, name: str, public: str | None, system: str | None) -> None:
        """Refuse what could define entities: a few hundred bytes of them expand to gigabytes."""
        raise UrdfError(
            "a document type",
            file=self._path,
            field="XML",
            given=f"<!DOCTYPE {name}>",
            allowed="XML without <!DOCTYPE>",
        )

    def start(self, tag: str, attrs: dict[str, str]) -> ElementTree.Element:
        """Count an element in."""
        if tag.startswith("{") and tag.partition("}")[0].endswith("xacro"):
            raise _xacro(self._path)
        self._open.append(tag)
        self._elements += 1
        self._links += tag == "link" and len(self._open) == 2
        for what, count, most in (
            ("elements nested too deep", len(self._open), DEEPEST),
            ("too many links", self._links, MOST_LINKS),
            ("too many elements", self._elements, MOST_ELEMENTS),
            ("too many attributes", len(attrs), MOST_ATTRIBUTES),
            ("too long an attribute", max(map(len, (tag, *attrs, *attrs.values()))), LONGEST_ATTRIBUTE),
        ):
            if count > most:
                field = "/" + "/".join(name[:80] for name in self._open[:2])
                raise UrdfError(what, file=self._path, field=field, given=f"at least {count}", allowed=f"up to {most}")
        return super().start(tag, attrs)

    def end(self, tag: str) -> ElementTree.Element:
        """Count an element out."""
        self._open.pop()
        return super().end(tag)


def _with_prefixes(content: bytes) -> bytes:
    """A document that declares the prefixes of its tags, as other readers of URDFs know no namespaces."""
    tags = {tag for tag in _PREFIX.findall(content) if b"xmlns:" + tag not in content}
    declared = b"".join(b' xmlns:%s="%s"' % (tag, tag) for tag in sorted(tags)[:MOST_ATTRIBUTES])
    return content.replace(b"<robot", b"<robot" + declared, 1)


def _expanded(path: Path) -> bytes:
    """What xacro makes of a program that writes a URDF."""
    import xacro  # of the extra of the same name

    try:
        content: bytes = xacro.process_file(str(path)).toxml(encoding="utf-8")
    except Exception as error:  # it evaluates what the file says, and raises whatever comes of that
        raise UrdfError(
            "xacro cannot expand it",
            file=path,
            field="XML",
            given=" ".join(str(error).split()),
            allowed="a URDF in xacro",
        ) from error
    if len(content) > LARGEST_FILE:
        raise UrdfError(
            "too large",
            file=path,
            field="file",
            given=f"{len(content)} bytes from xacro",
            allowed=f"up to {LARGEST_FILE}",
        )
    return content


def _xacro(path: Path) -> UrdfError:
    """Error of a file that is a program which writes a URDF."""
    urdf = path.name.removesuffix(".xacro").removesuffix(".urdf") + ".urdf"
    command = f"xacro {path.name} -o {urdf if urdf != path.name else f'expanded_{urdf}'}"
    return UrdfError(
        "xacro, not a URDF", file=path, field="XML", given="<xacro:…>",
        allowed=f"the extra 'xacro' and a name that ends in .xacro, or the file that '{command}' writes",
    )  # fmt: skip
