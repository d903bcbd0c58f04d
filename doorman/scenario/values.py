"""Values of a scenario: numbers with their ranges, names, and the table that holds them."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Angle = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-2 * math.pi, le=2 * math.pi)]
DoorAngle = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-math.pi, le=math.pi)]
Pitch = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=-math.pi / 2, lt=math.pi / 2)]
Switch = Annotated[bool, Field(strict=True)]
Name = Annotated[str, Field(min_length=1)]


class Section(BaseModel):
    """A table of the TOML file: frozen, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")
