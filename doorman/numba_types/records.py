"""Records: named numbers and vectors of fixed length that kernels and Python both read and write.

A NamedTuple in a handle is what a kernel works on; a record is what it remembers. A record is passed as one pointer, also as a
field of a handle's NamedTuple, and has the same attributes in kernels and in Python.
"""

from __future__ import annotations

import ctypes
from collections import namedtuple
from typing import Annotated, Any, ClassVar, Self, cast, get_args, get_origin, get_type_hints

import numpy as np
from numba.core import types
from numba.core.imputils import lower_getattr_generic, lower_setattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr, signature
from numba.np import numpy_support
from numba.np.arrayobj import record_getattr, record_setattr

from doorman.arrays import Array
from doorman.numba_types.pointers import passed_as_pointer

Vector3 = Annotated[Array, 3]
"""Three numbers of a record."""


@passed_as_pointer
class RecordType(types.Type):
    """numba's type of a record; `content` is numba's own type of its memory."""

    def __init__(self, name: str, content: Any) -> None:
        self.content = content
        super().__init__(name=f"Record({name}, {content})")


class Record:
    """Base of records, whose fields are annotated as `float`, `int`, `bool` or `Annotated[Array, length]`; all begin as zeros.

    Args:
        values: Fields that begin as something else.
    """

    __slots__ = ("address", "memory", "floats", "integers")
    dtype: ClassVar[np.dtype[np.void]]
    _numba_type_: ClassVar[RecordType]
    _tuple: ClassVar[Any]

    def __init_subclass__(cls) -> None:
        kinds = {name: hint for name, hint in get_type_hints(cls, include_extras=True).items() if name not in _OWN}
        cls.dtype = np.dtype([(name, *_layout(hint)) for name, hint in kinds.items()], align=True)
        cls._numba_type_ = RecordType(f"{cls.__module__}.{cls.__qualname__}", numpy_support.from_dtype(cls.dtype))
        cls._tuple = namedtuple(cls.__name__, list(kinds))  # type: ignore[misc]
        fields: Any = cls.dtype.fields
        for name, hint in kinds.items():
            words, place = _WORDS.get(hint), fields[name][1] // 8
            setattr(cls, name, _number(words, place) if words else _field(name))

    def __init__(self, **values: Any) -> None:
        self._take(np.zeros(-(-self.dtype.itemsize // 8)))
        for name, value in values.items():
            self.memory[name] = value

    @classmethod
    def over(cls, floats: Array) -> Self:
        """A record of the numbers in an array of as many words, which it shares."""
        record = object.__new__(cls)
        record._take(floats)
        return record

    def _take(self, floats: Array) -> None:
        self.floats, self.integers = floats, floats.view(np.int64)
        self.memory: Any = np.ndarray((), self.dtype, floats)
        buffer: Any = floats  # read-only memory is refused: kernels write
        self.address = ctypes.addressof(ctypes.c_char.from_buffer(buffer))

    def assign(self, other: Self) -> None:
        """Take the values of another record of this kind."""
        self.integers[:] = other.integers

    def copy(self) -> Self:
        """A record of its own with the same values."""
        return self.over(self.floats.copy())

    _separate = copy

    def snapshot(self) -> Self:
        """The same names with a copy of the values, which Python reads faster than a record; no kernel takes it."""
        return cast(Self, self._tuple._make(np.ndarray((), self.dtype, self.floats.copy()).item()))

    def __reduce__(self) -> tuple[Any, ...]:
        return self.over, (self.floats.copy(),)


_OWN = get_type_hints(Record)
_WORDS = {float: "floats", int: "integers"}
"""Views of a record's memory, of numbers that are a word of it."""


def _layout(hint: Any) -> tuple[Any, ...]:
    if get_origin(hint) is Annotated:
        return np.float64, (get_args(hint)[1],)
    return ({int: np.int64, bool: np.bool_}.get(hint, np.float64),)


def _number(words: str, place: int) -> property:
    """A number by its place among the words: several times as fast as by its name."""

    def read(record: Record) -> Any:
        return getattr(record, words).item(place)

    def write(record: Record, value: Any) -> None:
        getattr(record, words)[place] = value

    return property(read, write)


def _field(name: str) -> property:
    def read(record: Record) -> Any:
        value = record.memory[name]
        return value if value.ndim else value.item()

    def write(record: Record, value: Any) -> None:
        record.memory[name] = value

    return property(read, write)


@infer_getattr
class _Fields(AttributeTemplate):
    key = RecordType

    def generic_resolve(self, record: RecordType, name: str) -> Any:  # type: ignore[override]
        return record.content.typeof(name) if name in record.content.fields else None


def _inside(context: Any, builder: Any, record: RecordType, value: Any) -> Any:
    return builder.bitcast(value, context.get_value_type(record.content))


@lower_getattr_generic(RecordType)
def _read(context: Any, builder: Any, record: RecordType, value: Any, name: str) -> Any:
    return record_getattr(context, builder, record.content, _inside(context, builder, record, value), name)


@lower_setattr_generic(RecordType)
def _write(context: Any, builder: Any, sig: Any, args: Any, name: str) -> None:
    record, kind = sig.args
    inside = _inside(context, builder, record, args[0])
    record_setattr(context, builder, signature(sig.return_type, record.content, kind), (inside, args[1]), name)
