"""What MuJoCo refuses is told with the URDF, the link and the mesh at fault."""

from __future__ import annotations

import pytest

from doorman.exceptions import UrdfError
from doorman.resources import urdf_directory

DOOR = (urdf_directory() / "hinged_door.urdf").read_text(encoding="utf-8")
FLAT = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
SHAPE = '<collision><geometry><mesh filename="{}"/></geometry></collision>'


def with_mesh(text: str, link: str, mesh: str) -> str:
    assert f'<link name="{link}">' in text
    return text.replace(f'<link name="{link}">', f'<link name="{link}">{SHAPE.format(mesh)}', 1)


@pytest.mark.parametrize(("mesh", "content"), [("flat.obj", FLAT), ("lost.stl", None), ("odd.xyz", "1 2 3")])
def test_a_mesh_of_the_door(flight, tmp_path, mesh, content):
    if content is not None:
        (tmp_path / mesh).write_text(content, encoding="utf-8")
    path = tmp_path / "door.urdf"
    path.write_text(with_mesh(DOOR, "frame", mesh), encoding="utf-8")
    with pytest.raises(UrdfError, match="mesh") as caught:
        flight(door__urdf=str(path))
    assert (caught.value.file, caught.value.field) == (str(path), "link frame/collision frame/0")
    assert mesh in str(caught.value.given)
