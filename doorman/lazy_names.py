"""Public names of a package that bring in their modules on their first use: importing the package loads nothing."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence


def lazy_names(
    package: str, modules: Mapping[str, str], packages: Sequence[str] = ()
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package."""

    def get(name: str) -> object:
        if name in packages:
            return importlib.import_module(f"{package}.{name}")  # which makes it an attribute of the package
        if name not in modules:
            raise AttributeError(f"module '{package}' has no attribute '{name}'", name=name)
        value = getattr(importlib.import_module(f"{package}.{modules[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    def names() -> list[str]:
        return sorted({*vars(sys.modules[package]), *modules, *packages})

    return get, names
