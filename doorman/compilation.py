"""Ahead-of-flight compilation: the decorator of every numba kernel, and its cache on disk.

numba does not notice when a kernel that another kernel calls has changed in a different file, so the cache directory is
named by a hash over the sources of all kernels and over the versions of numba and Python: a change anywhere starts afresh.

numba leaves it to the loader which copy of a function that several kernels contain is run, and takes the one that came first:
other instructions, and other last bits, in a process that compiles than in one that loads. Here every kernel runs its own.

Solver kernels are compiled once more for every type of model. For a type from outside the package they are kept in files of
their own, named by a hash over the sources behind it: its kernels may change too, and who runs doorman alone cannot import it.
"""

from __future__ import annotations

import hashlib
import os
import platform
import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import CodeType
from typing import Any, ParamSpec, TypeVar

import numba
from llvmlite import binding
from numba.core.caching import FunctionCache, IndexDataCacheFile
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.runtime.nrt import rtsys

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_PACKAGE = Path(__file__).parent
_FAST_MATH = {"contract", "reassoc", "nsz", "arcp"}  # no assumption that NaN or inf cannot occur: they must show
_TEACHES_NUMBA = re.compile(rb"^\s*(from|import) (numba|llvmlite)\b", re.MULTILINE)

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


@cache
def cache_directory() -> Path:
    """Directory of compiled kernels: under NUMBA_CACHE_DIR if set, else under the user's cache directory.

    Returns:
        An existing, writable directory; a temporary one where the user's cache directory cannot be written.
    """
    digest = hashlib.sha256(f"{numba.__version__} {sys.version} {platform.machine()}".encode())
    texts = {source: source.read_bytes() for source in sorted(_PACKAGE.rglob("*.py"))}
    folders = {source.parent for source, text in texts.items() if b"\n@kernel\n" in text}
    digest.update(Path(__file__).read_bytes())
    for source, text in texts.items():
        # the whole folder, as kernels depend on the layout of its NamedTuples, and whatever teaches numba something
        if source.parent in folders or _TEACHES_NUMBA.search(text):
            digest.update(text)
    base = os.environ.get("NUMBA_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    name = f"doorman-{digest.hexdigest()[:16]}"
    for candidate in (Path(base) / name, Path(tempfile.gettempdir()) / name):
        try:
            candidate.mkdir(parents=True, exist_ok=True)
            if os.access(candidate, os.W_OK):
                return candidate
        except OSError:
            continue
    return Path(tempfile.mkdtemp(prefix="doorman-"))


def kernel(function: Callable[Parameters, Result]) -> Callable[Parameters, Result]:
    """Compile a function of arrays and scalars with numba: cached on disk, without the GIL, IEEE errors as NaN and inf.

    Args:
        function: Plain Python function that imports every kernel it calls (a kernel passed as an argument is never cached).

    Returns:
        The dispatcher; its `py_func` is the plain function.
    """
    settings: Any = numba.config
    previous = settings.CACHE_DIR
    settings.CACHE_DIR = str(cache_directory())
    try:
        dispatcher: Any = numba.njit(nogil=True, error_model="numpy", fastmath=_FAST_MATH)(function)
        dispatcher._cache = _Cache(function)  # type: ignore[no-untyped-call]
        _kernels.append(dispatcher)
        compiled: Callable[Parameters, Result] = dispatcher
        return compiled
    finally:
        settings.CACHE_DIR = previous


def kernel_counts() -> KernelCounts:
    """How many kernels this process has compiled and loaded so far."""
    stats = [kernel.stats for kernel in _kernels]
    return KernelCounts(
        compiled=sum(sum(stat.cache_misses.values()) for stat in stats),
        loaded=sum(sum(stat.cache_hits.values()) for stat in stats),
    )


def cache_content() -> CacheContent:
    """What the cache on disk holds: kernels of this version of the package, for all models and sizes so far."""
    directory = cache_directory()
    files = [file for file in directory.rglob("*") if file.suffix in (".nbc", ".nbi")]
    kernels = sum(file.suffix == ".nbc" for file in files)  # .nbi: numba's index of the kernels of one function
    return CacheContent(directory, kernels, sum(file.stat().st_size for file in files))


def belongs_to(model: type, kernel: Callable[..., None]) -> None:
    """Note that kernels compiled for a type of model contain this one.

    Args:
        model: NamedTuple type.
        kernel: What `kernel` returned.
    """
    if model.__module__.partition(".")[0] != _PACKAGE.name:
        code: CodeType = getattr(kernel, "py_func", kernel).__code__
        _sources.setdefault(model, set()).add(Path(code.co_filename))


class _SelfContained(JITCodeLibrary):
    """Machine code of one kernel whose calls of other kernels go to the copies in it.

    The bitcode for linking it into other kernels comes from the cache too, and is parsed when one is compiled.
    """

    _bitcode: bytes = b""

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> _SelfContained:
        name, _, (machine_code, bitcode) = state
        library = cls(codegen, name)
        library.enable_object_caching()  # type: ignore[no-untyped-call]
        library._set_compiled_object(machine_code)  # type: ignore[no-untyped-call]
        library._finalize_final_module()
        library._bitcode = bitcode
        return library

    def get_pointer_to_function(self, name: str) -> int:
        if self._bitcode and self._shared_module is None:  # numba's list of what is defined knows nothing of it yet
            return int(self._codegen._engine.get_function_address(name))
        return int(super().get_pointer_to_function(name))  # type: ignore[no-untyped-call]

    def _get_module_for_linking(self) -> Any:
        if self._bitcode and self._shared_module is None:
            self._shared_module = binding.parse_bitcode(self._bitcode)
            self._codegen._engine._load_defined_symbols(self._shared_module)  # type: ignore[no-untyped-call]
        return super()._get_module_for_linking()  # type: ignore[no-untyped-call]

    def _finalize_final_module(self) -> None:
        if self._shared_module is None and any(True for _ in self._final_module.functions):
            self._shared_module = self._to_share()  # before the copies are hidden, as other kernels are to inline them
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == binding.Linkage.linkonce_odr:
                    function.linkage = binding.Linkage.internal
        super()._finalize_final_module()  # type: ignore[no-untyped-call]

    def _to_share(self) -> Any:
        """A copy for linking into other kernels, as numba would make it later."""
        copy = self._final_module.clone()
        for function in copy.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.external:
                function.linkage = binding.Linkage.linkonce_odr
        return copy


JITCPUCodegen._library_class = _SelfContained


class _Cache(FunctionCache):
    """Cache of one kernel, with an index of its own for every set of model types from outside the package."""

    def load_overload(self, signature: Any, target: Any) -> Any:
        """Load a kernel without what only a compiler needs of numba, which takes half a second to import."""
        if _foreign_models(signature):  # whose code may be anything
            return super().load_overload(signature, target)  # type: ignore[no-untyped-call]
        rtsys.initialize(target)
        return self._load_overload(signature, target)

    def _load_overload(self, signature: Any, target: Any) -> Any:
        with self._files_for(signature):
            return super()._load_overload(signature, target)  # type: ignore[no-untyped-call]

    def _save_overload(self, signature: Any, data: Any) -> None:
        with self._files_for(signature):
            super()._save_overload(signature, data)  # type: ignore[no-untyped-call]

    @contextmanager
    def _files_for(self, signature: Any) -> Iterator[None]:
        files = self._cache_file
        digest = _digest_of(_foreign_models(signature))
        if digest:
            name, stamp = f"{self._impl.filename_base}-{digest}", self._impl.locator.get_source_stamp()
            self._cache_file = IndexDataCacheFile(self._cache_path, name, stamp)  # type: ignore[no-untyped-call]
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
