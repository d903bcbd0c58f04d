"""Dataclasses whose fields are stored at once are frozen dataclasses in all else."""

from __future__ import annotations

import copy
import inspect
import pickle
from dataclasses import FrozenInstanceError, dataclass, replace

import pytest

from doorman.stored_at_once import stored_at_once


@stored_at_once
@dataclass(frozen=True)
class Quick:
    first: float
    second: tuple[int, ...] = (1, 2)


@dataclass(frozen=True)
class Usual:
    first: float
    second: tuple[int, ...] = (1, 2)


def test_it_is_made_like_a_usual_one() -> None:
    assert inspect.signature(Quick) == inspect.signature(Usual)
    for made in (Quick(1.0), Quick(first=1.0, second=(1, 2)), Quick(1.0, (1, 2))):
        assert vars(made) == vars(Usual(1.0))
        assert made == Quick(1.0) != Quick(2.0)
    with pytest.raises(TypeError, match="first"):
        Quick()  # type: ignore[call-arg]


def test_it_is_frozen_and_can_be_copied() -> None:
    made = Quick(1.0)
    with pytest.raises(FrozenInstanceError):
        made.first = 2.0  # type: ignore[misc]
    assert replace(made, first=3.0) == Quick(3.0)
    for other in (copy.deepcopy(made), pickle.loads(pickle.dumps(made))):
        assert other == made and other is not made
