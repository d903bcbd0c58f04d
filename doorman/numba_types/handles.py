"""Handles: a NamedTuple of many arrays passed to kernels as one pointer.

A kernel's arguments are unboxed one by one and passed on number by number: with a hundred arrays a call takes longer than
its work, and compiles slowly. A handle keeps the NamedTuple in memory in the compiled code's layout; a kernel takes the
handle and reads its fields by name, as it would those of the NamedTuple: what is used is loaded, nothing else, and references
are not counted. A field that is a NamedTuple is a handle again.
"""

from __future__ import annotations

import struct
from typing import Any, Generic, TypeVar, cast

import numba
import numpy as np
from llvmlite import ir
from numba.core import types
from numba.core.imputils import lower_getattr_generic
from numba.core.registry import cpu_target
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numpy.typing import NDArray

from doorman.numba_types.function_tables import FunctionTable
from doorman.numba_types.pointers import BYTES, passed_as_pointer
from doorman.numba_types.records import Record

T = TypeVar("T")


@passed_as_pointer
class HandleType(types.Type):
    """numba's type of a handle."""

    def __init__(self, content: Any) -> None:
        self.content = content
        # numba tells types apart by their names, and its name of a NamedTuple leaves out the module
        module = getattr(getattr(content, "instance_class", None), "__module__", "")
        super().__init__(name=f"Handle({module}.{content})")


class Handle(Generic[T]):
    """A NamedTuple of numbers, tuples and writable arrays, held for kernels; its arrays are shared, its numbers copied.

    Args:
        content: The NamedTuple. A handle's kernels see the arrays as they are and the numbers as they were.
    """

    __slots__ = ("content", "address", "_memory", "_numba_type_")

    def __init__(self, content: T) -> None:
        self.content = content
        self._numba_type_ = HandleType(numba.typeof(content))
        self._memory = _packed(content)
        self.address = int(self._memory.ctypes.data)

    def replace(self, content: T) -> None:
        """Hold another NamedTuple of the same type."""
        self.content = content
        self._memory[:] = _packed(content)

    def __reduce__(self) -> tuple[Any, ...]:
        return Handle, (self.content,)  # a copy has memory of its own, with the addresses of its own arrays


def separate(content: T) -> T:
    """A NamedTuple's copy that shares no array with it."""
    if isinstance(content, np.ndarray):
        return cast(T, content.copy(order="K"))
    if hasattr(content, "_separate"):
        return cast(T, content._separate())
    if not isinstance(content, tuple):
        return content
    parts = [separate(part) for part in content]
    return cast(T, type(content)(*parts) if hasattr(content, "_fields") else tuple(parts))


def held(content: T) -> T:
    """A handle of a NamedTuple, typed as what it holds: to a kernel they are the same."""
    return cast(T, Handle(content))


def _borrowed(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """A value whose arrays own nothing, with the memory of the given one."""
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder, value)
        array.meminfo = ir.Constant(array.meminfo.type, None)
        array.parent = ir.Constant(array.parent.type, None)
        return array._getvalue()
    if isinstance(kind, types.BaseTuple):
        for i in range(len(kind)):
            item = kind[i]  # type: ignore[index]
            part = _borrowed(context, builder, item, builder.extract_value(value, i))
            value = builder.insert_value(value, part, i)
    return value


def _packed(content: Any) -> NDArray[np.int64]:
    """A NamedTuple in the compiled code's layout: every number, address or length takes a word of its own."""
    words: list[int] = []
    _append(words, content)
    context = cpu_target.target_context
    size: int = context.get_abi_sizeof(context.get_data_type(numba.typeof(content)))
    if size != 8 * len(words):
        raise TypeError(f"{type(content).__name__} holds more than floats, integers, arrays and tuples of them")
    return np.array([*words, 0], dtype=np.int64)


def _append(words: list[int], content: Any) -> None:
    """Append the words of a part."""
    if isinstance(content, np.ndarray):
        words += [0, 0, content.size, content.itemsize, content.ctypes.data, *content.shape, *content.strides]
    elif isinstance(content, tuple):
        for part in content:
            _append(words, part)
    elif isinstance(content, float):
        words.append(struct.unpack("q", struct.pack("d", content))[0])
    elif isinstance(content, FunctionTable):
        words += [content.address, 0]
    elif isinstance(content, Record):
        words.append(content.address)
    else:
        words.append(int(content))


@infer_getattr
class _Fields(AttributeTemplate):
    key = HandleType

    def generic_resolve(self, handle: HandleType, name: str) -> Any:  # type: ignore[override]
        fields = handle.content.fields
        if name not in fields:
            return None
        kind = handle.content[fields.index(name)]
        return HandleType(kind) if isinstance(kind, types.BaseNamedTuple) else kind


@lower_getattr_generic(HandleType)
def field_of(context: Any, builder: Any, handle: HandleType, value: Any, name: str) -> Any:
    """A field's value, with its memory borrowed."""
    index = handle.content.fields.index(name)
    kind = handle.content[index]
    content = builder.bitcast(value, context.get_data_type(handle.content).as_pointer())
    place = builder.gep(content, [ir.Constant(ir.IntType(32), i) for i in (0, index)])
    if isinstance(kind, types.BaseNamedTuple):  # a handle itself
        return builder.bitcast(place, BYTES)
    loaded = builder.load(place, align=8)
    loaded.set_metadata("invariant.load", builder.module.add_metadata([]))
    return _borrowed(context, builder, kind, context.data_model_manager[kind].from_data(builder, loaded))
