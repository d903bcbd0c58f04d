"""Ahead-of-flight compilation: the decorator of every numba kernel, and its cache on disk.

numba does not notice when a kernel that another kernel calls has changed in a different file, so the cache directory is
named by a hash over the sources of all kernels and over the versions of numba and Python: a change anywhere starts afresh.

numba leaves it to the loader which copy of a function that several kernels contain is run, and takes the one that came first:
other instructions, and other last bits, in a process that compiles than in one that loads. Here every kernel runs its own.

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
from typing import Any, ParamSpec, TypeVar

import numba
from llvmlite import binding
from numba.core.caching import CompileResultCacheImpl, FunctionCache, UserProvidedCacheLocator
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.runtime.nrt import rtsys

from doorman.cache_files import CheckedFiles
from doorman.cache_place import find_directory, say_once
from doorman.exceptions import DoormanError

Parameters = ParamSpec("Parameters")
Result = TypeVar("Result")

_PACKAGE = Path(__file__).parent
_FAST_MATH = {"contract", "reassoc", "nsz", "arcp"}  # no assumption that NaN or inf cannot occur: they must show
_SHAPE_CODE = ("OPT", "BOUNDSCHECK", "DEBUGINFO_DEFAULT", "LOOP_VECTORIZE", "SLP_VECTORIZE")
"""numba's settings, from the environment, that change what is compiled."""
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


def check_compiler() -> None:
    """Check that numba compiles.

    Raises:
        DoormanError: if it is told not to.
    """
    if numba.config.DISABLE_JIT:  # type: ignore[attr-defined]
        raise DoormanError(
            "doorman's kernels exist as compiled code only", field="NUMBA_DISABLE_JIT", given=1, allowed="0, or not set"
        )


check_compiler()  # before anything teaches numba, which then fails in other words


@cache
def cache_directory() -> Path:
    """Directory of compiled kernels: under NUMBA_CACHE_DIR if set, else under the user's cache directory.

    Returns:
        An existing directory that this user alone may write; a temporary one where the user's cache directory is not such.

    Raises:
        OSError: if nothing can be written anywhere.
    """
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
    """Compile a function of arrays and scalars with numba: cached on disk, without the GIL, IEEE errors as NaN and inf.

    Args:
        function: Plain Python function that imports every kernel it calls (a kernel passed as an argument is never cached).

    Returns:
        The dispatcher; its `py_func` is the plain function.

    Raises:
        DoormanError: if numba is told not to compile.
    """
    check_compiler()
    dispatcher: Any = numba.njit(nogil=True, error_model="numpy", fastmath=_FAST_MATH)(function)
    directory = _directory_if_any()
    if directory is not None and Path(inspect.getfile(function)).is_file():
        dispatcher._cache = _Cache(function, directory)
    _kernels.append(dispatcher)
    compiled: Callable[Parameters, Result] = dispatcher
    return compiled


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


class _Locator(UserProvidedCacheLocator):
    """Place of one function's files; made when the first is written."""

    def __init__(self, function: Callable[..., Any], directory: Path) -> None:
        self._py_file = inspect.getfile(function)
        self._lineno = function.__code__.co_firstlineno
        self._cache_path = str(directory / self.get_suitable_cache_subpath(self._py_file))  # type: ignore[no-untyped-call]

    def ensure_cache_path(self) -> None:
        pass


class _Implementation(CompileResultCacheImpl):
    """numba's, at a place that it does not choose."""

    def __init__(self, function: Callable[..., Any], directory: Path) -> None:
        self._locator, self._lineno = _Locator(function, directory), function.__code__.co_firstlineno
        name = f"{Path(inspect.getfile(function)).stem}.{function.__qualname__}"
        self._filename_base = self.get_filename_base(name, getattr(sys, "abiflags", ""))  # type: ignore[no-untyped-call]


class _Cache(FunctionCache):
    """Cache of one kernel, with an index of its own for every set of model types from outside the package."""

    def __init__(self, function: Callable[..., Any], directory: Path) -> None:
        self._name, self._py_func = repr(function), function
        self._impl = _Implementation(function, directory)
        self._cache_path = self._impl.locator.get_cache_path()
        self._cache_file = self._files(self._impl.filename_base)
        self.enable()  # type: ignore[no-untyped-call]

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
