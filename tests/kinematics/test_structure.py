"""The structure of a URDF is checked once for every content, and every caller has a tree of its own."""

from __future__ import annotations

from pathlib import Path

import pytest
from urdf_variants import DOOR, write_edited

from doorman import Model, Scenario
from doorman.exceptions import UrdfError
from doorman.kinematics.urdf.structure import check_structure


def test_a_callers_change_is_its_own(tmp_path: Path) -> None:
    path = write_edited(tmp_path / "door.urdf", DOOR)
    first = check_structure(path)
    links = len(first.findall("link"))
    for link in first.findall("link"):
        first.remove(link)
    assert len(check_structure(path).findall("link")) == links > 0


def test_a_file_that_has_changed_is_checked_anew(tmp_path: Path) -> None:
    path = write_edited(tmp_path / "door.urdf", DOOR)
    check_structure(path)
    write_edited(path, DOOR, ("</robot>", "<link/></robot>"))
    for _ in range(2):  # what is refused is refused again
        with pytest.raises(UrdfError, match="without a name"):
            check_structure(path)


def test_a_model_sees_a_file_as_it_is_when_it_is_made(tmp_path: Path) -> None:
    path = write_edited(tmp_path / "door.urdf", DOOR)
    given = {"door.urdf": str(path)}
    assert Model(Scenario.load("paper", given)).door.width == pytest.approx(1.2)
    path.write_text(path.read_text(encoding="utf-8").replace("1.2 0.04 1.6", "1.1 0.04 1.6"), encoding="utf-8")
    assert Model(Scenario.load("paper", given)).door.width != pytest.approx(1.2)
