"""Visual shapes of URDFs."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from urdf_variants import DOOR, VEHICLE, robot_data_vehicle

from doorman.exceptions import UrdfError
from doorman.visualization.scene.shapes import visual_shapes

URDF = """<robot name="shapes">
  <material name="named"><color rgba="0.1 0.2 0.3 0.4"/></material>
  <link name="first">
    <visual><geometry><box size="1 2 3"/></geometry><material name="named"/></visual>
    <visual><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><geometry><cylinder radius="0.1" length="0.5"/></geometry>
      <material name="own"><color rgba="1 0 0 1"/></material></visual>
    <visual><geometry><sphere radius="0.2"/></geometry></visual>
  </link>
  <joint name="joint" type="fixed"><origin xyz="0 0.3 0.4"/><parent link="second"/><child link="third"/></joint>
  <joint name="other" type="fixed"><parent link="first"/><child link="second"/></joint>
  <link name="second"><visual><geometry><mesh filename="nowhere.stl"/></geometry></visual></link>
  <link name="third"/>
</robot>"""


def test_primitives_colours_and_rods(tmp_path):
    path = tmp_path / "shapes.urdf"
    path.write_text(URDF, encoding="utf-8")
    box, cylinder, sphere, rod = visual_shapes(path)
    assert (box.link, box.kind, box.size, box.color) == ("first", "box", (1.0, 2.0, 3.0), (0.1, 0.2, 0.3, 0.4))
    np.testing.assert_array_equal(box.placement, np.eye(4))
    assert (cylinder.kind, cylinder.size, cylinder.color) == ("cylinder", (0.1, 0.5), (1.0, 0.0, 0.0, 1.0))
    np.testing.assert_allclose(cylinder.placement[:3], [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3]], atol=1e-12)
    assert (sphere.kind, sphere.size) == ("sphere", (0.2,)) and sphere.color == (0.6, 0.6, 0.6, 1.0)
    assert rod.link == "second" and rod.size[1] == pytest.approx(0.5)
    for end, expected in ((-0.25, [0, 0, 0]), (0.25, [0, 0.3, 0.4])):
        np.testing.assert_allclose((rod.placement @ [0, 0, end, 1])[:3], expected, atol=1e-12)
    np.testing.assert_allclose(rod.placement[:3, :3] @ rod.placement[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rod.placement[:3, :3]) == pytest.approx(1.0)


@pytest.mark.parametrize("path", [VEHICLE, DOOR])
def test_shipped_urdfs_are_drawn_completely(path):
    shapes = visual_shapes(path)
    assert len(shapes) == len(ElementTree.parse(path).getroot().findall("link/visual"))
    assert len({shape.color for shape in shapes}) >= 5  # materials are found by their names


def test_links_of_meshes_become_rods_to_their_joints():
    path, names = robot_data_vehicle("hextilt_flying_arm_5")
    shapes = visual_shapes(path)
    assert {shape.kind for shape in shapes} == {"cylinder"}
    assert names.base_link in {shape.link for shape in shapes}


def test_missing_file(tmp_path):
    with pytest.raises(UrdfError):
        visual_shapes(tmp_path / "missing.urdf")


@pytest.mark.parametrize("rgba", ["0.1 0.2 0.3", "red", ""])
def test_colours_that_are_none(tmp_path, rgba):
    path = tmp_path / "shapes.urdf"
    path.write_text(URDF.replace("1 0 0 1", rgba), encoding="utf-8")
    with pytest.raises(UrdfError, match="material own/color@rgba"):
        visual_shapes(path)
