"""What `copy` and `pickle` make of objects that own more than numbers: a full rebuild, or a refusal in a sentence.

A kernel's memory, a device, a thread or a simulator cannot be copied attribute by attribute. A class says which of the two it is
by its base: `CopiedWhole` where every part can be rebuilt, `Uncopied` where one cannot.
"""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable
from typing import Any, Generic, NoReturn, Self, SupportsIndex, TypeVar, cast

T = TypeVar("T")


class CopiedWhole:
    """Base of what writes to memory of its own: `copy.copy` is `copy.deepcopy`, so that no two of them share that memory."""

    __slots__ = ()

    def __copy__(self) -> Self:
        return copy.deepcopy(self)


class Uncopied:
    """Base of what holds a device, a thread, a file or a simulator: it is neither copied nor pickled."""

    __slots__ = ()

    def __reduce_ex__(self, protocol: SupportsIndex) -> NoReturn:
        name = type(self).__name__
        raise TypeError(
            f"{name} cannot be copied or pickled: it holds a device, a thread, a file or a simulator; "
            f"make another {name} from the same arguments, in the process that uses it"
        )


class PerThread(threading.local, Generic[T]):
    """A value of which every thread has its own; a copy begins without any."""

    def get(self, make: Callable[[], T]) -> T:
        """This thread's value."""
        try:
            return cast(T, self.__dict__["value"])
        except KeyError:
            self.__dict__["value"] = value = make()
            return value

    def __reduce__(self) -> tuple[Any, ...]:
        return PerThread, ()
