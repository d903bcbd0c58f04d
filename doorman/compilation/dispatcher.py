"""A kernel as numba's dispatcher: compiled for its callers, and for Python when Python calls it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba.core import event
from numba.core.caching import NullCache
from numba.core.compiler_lock import global_compiler_lock
from numba.core.errors import ForceLiteralArg, TypingError
from numba.core.registry import CPUDispatcher
from numba.core.runtime.nrt import rtsys
from numba.core.sigutils import normalize_signature
from numba.core.typing.templates import make_concrete_template

from doorman.compilation import operator_types, variable_lists
from doorman.compilation.machine_code import SelfContained

_OPTIONS = {
    "nopython": True,
    "nogil": True,
    "boundscheck": None,
    "error_model": "numpy",
    "fastmath": {"contract", "reassoc", "nsz", "arcp"},  # no assumption that NaN or inf cannot occur: they must show
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}

operator_types.install()
variable_lists.install()


class _Key:
    """What numba finds code by that can only be linked. It cannot be called: there is no machine code yet."""


class Kernel(CPUDispatcher):
    """A function that compiled functions link, and that Python calls through an entry made at its first call.

    Most kernels are only called by others and need no machine code of their own. An entry is made of what callers link, and
    contains all it calls.

    Args:
        function: Plain Python function.

    Attributes:
        overloads: What callers link, one for every set of argument types.
        entries: What Python calls, one for every set of argument types that it has called with.
        addresses: C functions, one for every set of argument types that `address` was called with.
        entry_cache: Cache of `entries`; `_cache` is that of `overloads`.
    """

    _cache: Any
    _cache_hits: Any
    _cache_misses: Any
    _compiler: Any
    _insert: Any

    def __init__(self, function: Callable[..., Any], *_: Any) -> None:  # the rest is given when numba unpickles one
        super().__init__(py_func=function, targetoptions=dict(_OPTIONS))
        self.entries: dict[tuple[Any, ...], Any] = {}
        self.addresses: dict[tuple[Any, ...], int] = {}
        self.entry_cache: Any = NullCache()

    def compile(self, sig: Any) -> Any:
        """Entry for Python: of this process, from the cache, or made."""
        with global_compiler_lock:
            args = tuple(normalize_signature(sig)[0])
            if args not in self.entries:
                self.entries[args] = entry = self._loaded(self.entry_cache, args) or self._made(args, _wrap_for_python)
                self._insert([kind._code for kind in args], entry.entry_point, False)
            return self.entries[args].entry_point

    def address(self, sig: Any, wrap: Callable[..., None]) -> int:
        """Address of a C function: of this process, from the cache, or made. A kernel has this or an entry for Python."""
        with global_compiler_lock:
            args = tuple(normalize_signature(sig)[0])
            if args not in self.addresses:
                entry = self._loaded(self.entry_cache, args) or self._made(args, wrap)
                self.entries[args] = entry  # keeps the machine code
                name = entry.fndesc.llvm_cfunc_wrapper_name
                self.addresses[args] = entry.library.get_pointer_to_function(name)
            return self.addresses[args]

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Signature for a caller in compiled code, which links what is compiled here."""
        pysig, folded = self._compiler.fold_argument_types(args, kws)
        with global_compiler_lock:
            self._linked(tuple(folded))
        name = f"CallTemplate({self.py_func.__name__})"
        template = make_concrete_template(name, key=self.py_func.__name__, signatures=self.nopython_signatures)
        return template, pysig, folded, {}

    def get_compile_result(self, sig: Any) -> Any:
        """Refuse to be a value in compiled code, which would need machine code of another kind."""
        raise TypingError(f"the kernel {self.py_func.__name__} is no value: compiled code calls it by its name")

    def add_overload(self, cres: Any) -> None:
        """Note what callers link."""
        key = _Key()
        self.targetctx.insert_user_function(key, cres.fndesc, [cres.library])
        self.overloads[tuple(cres.signature.args)] = cres._replace(entry_point=key)

    def _reset_overloads(self) -> None:
        super()._reset_overloads()  # type: ignore[misc]
        self.entries.clear()
        self.addresses.clear()

    def _loaded(self, cache: Any, args: tuple[Any, ...]) -> Any:
        """From a cache; None if it is not there."""
        found = cache.load_overload(args, self.targetctx)
        if found is not None:
            self._cache_hits[args] += 1
        return found

    def _linked(self, args: tuple[Any, ...]) -> Any:
        """What callers link: of this process, from the cache, or compiled."""
        if args not in self.overloads:
            found = self._loaded(self._cache, args)
            self.add_overload(found or self._compiled(args))
            if found is None:
                self._cache.save_overload(args, self.overloads[args])
        return self.overloads[args]

    def _compiled(self, args: tuple[Any, ...]) -> Any:
        self._cache_misses[args] += 1
        details = {"dispatcher": self, "args": args, "return_type": None}
        with self._compiling_counter, event.trigger_event("numba:compile", data=details):
            try:
                return self._compiler.compile(args, None)
            except ForceLiteralArg as error:
                raise error.bind_fold_arguments(lambda args, kws: self._compiler.fold_argument_types(args, kws)[1])

    def _made(self, args: tuple[Any, ...], wrap: Callable[..., None]) -> Any:
        """An entry: the machine code, kept in the cache."""
        details = {"dispatcher": self, "args": args, "return_type": None}
        with event.trigger_event("numba:compile", data=details):
            code = self._linked(args)
            self._cache_misses[args] = 1  # one kernel, whether it was compiled now, before, or by another process
            self.targetctx.refresh()
            context = self.targetctx.subtarget(enable_nrt=True)  # for arrays that Python gives and gets
            library = SelfContained.entry(context.codegen(), self.py_func.__qualname__)
            with context.push_code_library(library):
                wrap(context, library, code)
            for each in (code.library, rtsys.library):
                library.add_linking_library(each)
            entry_point = context.get_executable(library, code.fndesc, code.environment)
        entry = code._replace(library=library, entry_point=entry_point)
        self.entry_cache.save_overload(args, entry)
        return entry


def _wrap_for_python(context: Any, library: Any, code: Any) -> None:
    context.create_cpython_wrapper(library, code.fndesc, code.environment, None, release_gil=True)
