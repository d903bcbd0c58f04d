"""Machine code of kernels: what Python calls has its own copies of all it calls, and nothing else is made into machine code.

numba makes machine code of every function, also of those that only other compiled functions call, with copies of all that these
call in turn. Here a function without an entry for Python is linked into its callers and optimised there, with them.

numba leaves it to the loader which copy of a function that several kernels contain is run, and takes the one that came first:
other instructions, and other last bits, in a process that compiles than in one that loads. Here every kernel runs its own.
"""

from __future__ import annotations

import itertools
import os
from typing import Any

from llvmlite import binding
from numba.core.bytecode import FunctionIdentity
from numba.core.codegen import JITCodeLibrary, JITCPUCodegen
from numba.core.environment import lookup_environment
from numba.core.runtime.nrt import rtsys

_ENTRIES = "_ZN7cpython", "cfunc."
"""What the names of functions begin with that Python calls, or others by their addresses."""

_ENVIRONMENT = "_ZN08NumbaEnv"
"""What the names of pointers to a function's Python globals begin with."""

_UNRESOLVED = ".numba.unresolved$"
"""What the names of pointers that recursive functions call begin with; numba fills them when it makes machine code."""

_set_known_environment: Any = JITCPUCodegen.set_env


class SelfContained(JITCodeLibrary):
    """Code of one function, whose calls of other functions go to the copies in it."""

    _made = False
    """Whether there is machine code of it."""
    _optimized = False
    _is_last = False
    """Whether no other code will contain this one's."""

    @classmethod
    def entry(cls, codegen: Any, name: str) -> SelfContained:
        """An empty library for a function that only Python calls."""
        library = cls(codegen, name)
        library.enable_object_caching()
        library._is_last = True
        return library

    @property
    def is_tied_to_process(self) -> bool:
        """Whether the code reads addresses of this process, as functions do that call each other in a circle."""
        return any(variable.name.startswith(_UNRESOLVED) for variable in self._final_module.global_variables)

    @classmethod
    def _unserialize(cls, codegen: Any, state: Any) -> SelfContained:
        name, kind, content = state
        library = cls(codegen, name)
        library.enable_object_caching()
        library._finalized = True
        if kind == "linked":
            library._final_module = library._shared_module = binding.parse_bitcode(content)
            return library
        machine_code, rest = content
        library._set_compiled_object(machine_code)
        library._is_last, library._optimized = kind == "entry", True
        library._make()
        if kind == "entry":
            codegen._engine._defined_symbols.update(rest)
        else:
            library._shared_module = binding.parse_bitcode(rest)
            codegen._engine._load_defined_symbols(library._shared_module)
        return library

    def serialize_using_object_code(self) -> Any:
        """For files: an entry's machine code, what is linked as bitcode, or both for other functions, as numba has it."""
        self._ensure_finalized()
        if self._is_last:
            return self.name, "entry", (self._get_compiled_object(), sorted(_defined(self._final_module)))
        if not self._made:
            return self.name, "linked", self._get_module_for_linking().as_bitcode()
        return super().serialize_using_object_code()

    def get_pointer_to_function(self, name: str) -> int:
        """Address of a function, or 0 where this is no function of the library, as numba has it."""
        self._ensure_finalized()
        if not self._made and name in _defined(self._final_module):
            self._make()
        return int(super().get_pointer_to_function(name))

    @property
    def _is_called_by_address(self) -> bool:
        """Whether Python, a table of functions, or a function in a circle of calls reaches functions of this library."""
        return self.is_tied_to_process or any(each.name.startswith(_ENTRIES) for each in self._final_module.functions)

    def _optimize_final_module(self) -> None:
        """Optimise what becomes machine code; other code is optimised in its callers."""
        if self._is_called_by_address:
            if self._is_last:
                self._hide_copies()  # so that what is called once is inlined, and constant arguments are known
            super()._optimize_final_module()
            self._optimized = True

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._verify_declare_only_symbols()
        self._finalized = True
        if self._is_called_by_address:
            self._make()

    def _make(self) -> None:
        """Make, or load, the machine code."""
        if not (self._is_last or _is_empty(self._final_module)):
            self._get_module_for_linking()  # before the copies are hidden
        if not self._optimized:
            super()._optimize_final_module()
            self._optimized = True
        self._hide_copies()
        if self._is_last:
            self._check_references()
        self._made = True
        if self.is_tied_to_process:  # the loader takes numba's own functions before this, not in the midst of it
            rtsys.library.get_pointer_to_function("nrt_unresolved_abort")
        super()._finalize_final_module()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name) if variable.name.startswith(_ENVIRONMENT) else None
            if environment is not None:
                _set_environment(self._codegen, variable.name, environment)

    def _hide_copies(self) -> None:
        """Keep the loader from running other libraries' copies of what this one contains."""
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == binding.Linkage.linkonce_odr:
                function.linkage = binding.Linkage.internal

    def _check_references(self) -> None:
        """Refuse code with calls that lead nowhere: the loader would make them calls of address 0."""
        for function in self._final_module.functions:
            name = function.name
            if function.is_declaration and not (
                name.startswith("llvm.")
                or binding.address_of_symbol(name)
                or self._codegen._engine.is_symbol_defined(name)
            ):
                raise RuntimeError(f"{self.name}: nothing defines {name}")


def _is_empty(module: Any) -> bool:
    return not any(True for _ in module.functions)


def _defined(module: Any) -> set[str]:
    """Names by which a module's functions and variables are found from outside."""
    hidden = binding.Linkage.internal, binding.Linkage.private
    every = (*module.functions, *module.global_variables)
    return {each.name for each in every if not each.is_declaration and each.linkage not in hidden}


def _set_environment(codegen: Any, name: str, environment: Any) -> None:
    """Tell machine code where a function's Python globals are; names that do not exist yet follow when they do."""
    if codegen._engine.is_symbol_defined(name):
        _set_known_environment(codegen, name, environment)


JITCPUCodegen._library_class = SelfContained
JITCPUCodegen.set_env = _set_environment  # type: ignore[method-assign]
FunctionIdentity._unique_ids = itertools.count(int.from_bytes(os.urandom(6), "big"))
"""Part of every function's name: no function from the cache has the name of another one of this process."""
