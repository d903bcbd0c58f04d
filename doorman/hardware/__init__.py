"""Hardware: the interface that the mission flies, and the adapters behind it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from doorman.lazy_names import lazy_names

if TYPE_CHECKING:  # the types of the names below; no layer hides an import here
    from doorman.hardware.interface import Backend, Command, Measurement

__all__ = ["Backend", "Command", "Measurement"]

if not TYPE_CHECKING:  # a type checker would take any name for granted
    __getattr__, __dir__ = lazy_names(__name__, dict.fromkeys(__all__, "interface"))
