"""The decorator of every numba kernel, and the cache on disk of what it compiles.

numba does not notice when a kernel that another kernel calls has changed in a different file, so the cache directory is
named by a hash over the sources of all kernels and over the versions of numba and Python: a change anywhere starts afresh.

A kernel is kept in two forms: what other kernels link, and, once Python has called it, machine code that contains all it calls
(`dispatcher`, `machine_code`).

Solver kernels are compiled once more for every type of model. For a type from outside the package they are kept in files of
their own, named by a hash over the sources behind it: its kernels may change too, and who runs doorman alone cannot import it.

`cache_place` says where the cache is, `cache_files` how its files are checked. A cache that cannot be read or written costs time
and a warning, nothing else.
"""

from __future__ import annotations

import hashlib
import inspect
import platform
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import CodeType
from typing import Any, ParamSpec, TypeVar, cast

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator
from numba.core.runtime.nrt import rtsys

from doorman.compilation.cache_files import CheckedFiles
from doorman.compilation.cache_place import find_directory, say_once
from doorman.compilation.dispatcher import Kernel
from doorman.exceptions import DoormanError

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_PACKAGE = Path(__file__).parents[1]
PRINTED = "doorman_problem_"
"""Modules that doorman has printed begin with this."""

_SHAPE_CODE = ("OPT", "BOUNDSCHECK", "DEBUGINFO_DEFAULT", "LOOP_VECTORIZE", "SLP_VECTORIZE")
"""numba's settings, from the environment, that change what is compiled."""
_TEACHES_NUMBA = re.compile(rb"^\s*(from|import) (numba|llvmlite)\b", re.MULTILINE)

_LINKED = "-linked"
"""In the names of files of what other kernels link."""

_sources: dict[type, set[Path]] = {}
"""Files behind the model types from outside the package."""

_kernels: list[Any] = []
"""Every kernel of this process."""


@dataclass(frozen=True)
class KernelCounts:
    """Kernels of this process, one for every set of argument types."""

    compiled: int
    loaded: int
    """From the cache; what such a kernel calls comes with it and is not counted."""


@dataclass(frozen=True)
class CacheContent:
    """What the directory of compiled kernels holds."""

    directory: Path
    kernels: int
    """One for every set of argument types; those that others call are counted too."""
    size: int
    """[bytes]."""


def check_compiler() -> None:
    """Check that numba compiles."""
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        raise DoormanError(
            "doorman's kernels exist as compiled code only", field="NUMBA_DISABLE_JIT", given=1, allowed="0, or not set"
        )


check_compiler()  # before anything teaches numba, which then fails in other words


@cache
def cache_directory() -> Path:
    """Directory of compiled kernels: under NUMBA_CACHE_DIR if set, else under the user's cache directory."""
    settings = [f"{name}={getattr(numba.config, name, None)}" for name in _SHAPE_CODE]
    digest = hashlib.sha256(f"{numba.__version__} {sys.version} {platform.machine()} {settings}".encode())
    texts = {source: source.read_bytes() for source in sorted(_PACKAGE.rglob("*.py"))}
    folders = {source.parent for source, text in texts.items() if b"\n@kernel\n" in text}
    digest.update(Path(__file__).read_bytes())
    for source, text in texts.items():
        # the whole folder, as kernels depend on the layout of its NamedTuples, and whatever teaches numba something
        if source.parent in folders or _TEACHES_NUMBA.search(text):
            digest.update(text)
    return find_directory(f"doorman-{digest.hexdigest()[:16]}")


def kernel(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function of arrays and scalars with numba: cached on disk, without the GIL, IEEE errors as NaN and inf."""
    check_compiler()
    compiled: Callable[Parameters, Result] = kept(Kernel(function), function)
    return compiled


def entry(
    function: Callable[Parameters, Result], *like: Parameters.args, **_: Parameters.kwargs
) -> Callable[Parameters, Result]:
    """A kernel, compiled, for arguments of the types of these and no others: a call does not look at their types again.

    What is called in every tick has arguments of its caller's own, and to look at the type of a handle takes a microsecond.
    """
    kinds = tuple(numba.typeof(each) for each in like)  # type: ignore[no-untyped-call]
    return cast(Callable[Parameters, Result], cast(Any, function).compile(kinds))


def kept(dispatcher: Any, function: Callable[..., Any]) -> Any:
    """A kernel, with the cache on disk of what it compiles."""
    directory = _directory_if_any()
    if directory is not None and Path(inspect.getfile(function)).is_file():
        dispatcher._cache = _Cache(function, directory, _LINKED)
        dispatcher.entry_cache = _Cache(function, directory)
    _kernels.append(dispatcher)
    return dispatcher


@cache
def _directory_if_any() -> Path | None:
    try:
        return cache_directory()
    except OSError as error:
        say_once("place", f"compiled kernels are not kept, because nothing can be written ({error.strerror or error})")
        return None


def kernel_counts() -> KernelCounts:
    """How many kernels this process has compiled and loaded so far."""
    stats = [kernel.stats for kernel in _kernels]
    return KernelCounts(
        compiled=sum(sum(stat.cache_misses.values()) for stat in stats),
        loaded=sum(sum(stat.cache_hits.values()) for stat in stats),
    )


def known_kernels() -> int:
    """Kernels that modules and printed problems have brought so far; a run needs most of them, each for its arguments."""
    return len(_kernels)


def cache_content() -> CacheContent:
    """What the cache on disk holds: kernels of this version of the package, for all models and sizes so far."""
    directory = cache_directory()
    files = [file for file in directory.rglob("*") if file.suffix in (".nbc", ".nbi")]
    kernels = sum(file.suffix == ".nbc" and _LINKED in file.name for file in files)  # .nbi: index of one's kernels
    return CacheContent(directory, kernels, sum(file.stat().st_size for file in files))


def belongs_to(model: type, kernel: Callable[..., None]) -> None:
    """Note that kernels compiled for a type of model contain this one."""
    if model.__module__.partition(".")[0] != _PACKAGE.name:
        code: CodeType = getattr(kernel, "py_func", kernel).__code__
        _sources.setdefault(model, set()).add(Path(code.co_filename))


class _Locator(UserProvidedCacheLocator):
    """Place of one function's files; made when the first is written."""

    def __init__(self, function: Callable[..., Any], directory: Path) -> None:
        self._py_file = inspect.getfile(function)
        self._lineno = function.__code__.co_firstlineno
        path = Path(self._py_file)
        inside = path.is_relative_to(_PACKAGE)  # two copies of this version share what they compile
        place = str(Path("/", path.relative_to(_PACKAGE))) if inside else self._py_file
        self._cache_path = str(directory / self.get_suitable_cache_subpath(place))  # type: ignore[no-untyped-call]

    def ensure_cache_path(self) -> None:
        pass


class _Implementation(CompileResultCacheImpl):
    """numba's, at a place that it does not choose."""

    def __init__(self, function: Callable[..., Any], directory: Path, kind: str) -> None:
        self._locator, self._lineno = _Locator(function, directory), function.__code__.co_firstlineno
        name = f"{Path(inspect.getfile(function)).stem}.{function.__qualname__}"
        self._filename_base = self.get_filename_base(name, getattr(sys, "abiflags", "")) + kind  # type: ignore[no-untyped-call]

    def check_cachable(self, compiled: Any) -> bool:
        """Whether another process can run it."""
        return bool(super().check_cachable(compiled)) and not compiled.library.is_tied_to_process  # type: ignore[no-untyped-call]


class _Cache(FunctionCache):
    """Cache of one kernel, with an index of its own for every set of model types from outside the package."""

    def __init__(self, function: Callable[..., Any], directory: Path, kind: str = "") -> None:
        self._name, self._py_func = repr(function), function
        self._impl = _Implementation(function, directory, kind)
        self._cache_path = self._impl.locator.get_cache_path()
        self._cache_file = self._files(self._impl.filename_base)
        self.enable()  # type: ignore[no-untyped-call]

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Load a kernel without what only a compiler needs of numba, which takes half a second to import."""
        if any(
            not model.__module__.startswith(PRINTED) for model in _foreign_models(signature)
        ):  # code may be anything
            return super().load_overload(signature, target)  # type: ignore[no-untyped-call]
        rtsys.initialize(target)
        return self._load_overload(signature, target)

    def _load_overload(self, signature: Any, target: Any) -> Any:
        with self._files_for(signature):
            return super()._load_overload(signature, target)  # type: ignore[no-untyped-call]

    def _save_overload(self, signature: Any, data: Any) -> None:
        with self._files_for(signature):
            try:
                super()._save_overload(signature, data)  # type: ignore[no-untyped-call]
            except OSError as error:
                say_once("save", f"a compiled kernel cannot be kept in {self._cache_path} ({error.strerror or error})")

    def _files(self, name: str) -> CheckedFiles:
        return CheckedFiles(Path(self._cache_path), name, self._impl.locator.get_source_stamp())

    @contextmanager
    def _files_for(self, signature: Any) -> Iterator[None]:
        files = self._cache_file
        digest = _digest_of(_foreign_models(signature))
        if digest:
            self._cache_file = self._files(f"{self._impl.filename_base}-{digest}")
        try:
            yield
        finally:
            self._cache_file = files


def _foreign_models(types: Any) -> set[type]:
    """Model types from outside the package among numba's types, nested ones too."""
    types = getattr(types, "content", types)  # of a handle
    model = getattr(types, "instance_class", None)
    if model is not None and model.__module__.partition(".")[0] != _PACKAGE.name:
        return {model}
    inner = types if isinstance(types, tuple) else getattr(types, "types", ())
    return set().union(*map(_foreign_models, inner))


def _digest_of(models: set[type]) -> str:
    """Name of these types as they are now; empty for none."""
    digest = hashlib.sha256()
    for model in sorted(models, key=lambda model: (model.__module__, model.__qualname__)):
        digest.update(f"{model.__module__}.{model.__qualname__}".encode())
        for source in sorted(_sources.get(model, ())):
            digest.update(source.read_bytes() if source.is_file() else str(source).encode())
    return digest.hexdigest()[:16] if models else ""
