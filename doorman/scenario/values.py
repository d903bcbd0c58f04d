"""Values of a scenario: numbers with their ranges, names, and the table that holds them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from doorman.bounds import check_tables
from doorman.exceptions import ScenarioError
from doorman.scenario.errors import explain
from doorman.scenario.plain import plain
from doorman.scenario.units import with_radians

if TYPE_CHECKING:  # the same class under its own name, which is pydantic's alone
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Angle = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-2 * math.pi, le=2 * math.pi)]
DoorAngle = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-1.5 * math.pi, le=1.5 * math.pi)]
Pitch = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=-math.pi / 2, lt=math.pi / 2)]
Switch = Annotated[bool, Field(strict=True)]
Name = Annotated[str, Field(min_length=1)]


class _Checked(ModelMetaclass):
    """Sections whose constructor raises an error of ours; pydantic's own ways in raise pydantic's."""

    def __call__(cls, *arguments: Any, **values: Any) -> Any:
        section: Any = cls
        if arguments:
            raise ScenarioError(
                f"a {cls.__name__} is made of keywords", given=arguments[0],
                allowed=f"{', '.join(section.model_fields)}; Scenario.load reads names and files",
            )  # fmt: skip
        check_tables(values, ScenarioError)
        try:
            return super().__call__(**values)
        except ValidationError as error:
            raise explain(section, error) from None


class Section(BaseModel, metaclass=_Checked):
    """A table of the TOML file: frozen, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _plain(cls, values: Any) -> Any:
        values = plain(values)
        return with_radians(cls, values) if isinstance(values, dict) else values

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """A copy, with other values for some keys."""
        if not update:
            return super().model_copy(deep=deep)
        copy = type(self)(**{name: getattr(self, name) for name in self.model_fields_set} | dict(update))
        for name in self.__private_attributes__:
            setattr(copy, name, getattr(self, name))
        return copy

    def __hash__(self) -> int:
        return hashed(self.model_dump())


def hashed(values: Any) -> int:
    """Hash of numbers, texts, and lists and tables of them; equal values have equal hashes."""
    return hash(_hashable(values))


def _hashable(value: Any) -> Any:
    if isinstance(value, dict):
        return frozenset((key, _hashable(item)) for key, item in value.items())
    return tuple(map(_hashable, value)) if isinstance(value, (list, tuple)) else value
