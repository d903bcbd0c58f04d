"""Broken URDFs: each an error that names file, field, what was given and what is allowed, and nothing on the console."""

from __future__ import annotations

from pathlib import Path

import pytest
from urdf_variants import DOOR, VEHICLE, write_edited

from doorman.exceptions import UrdfError
from doorman.kinematics.doors.door import Door
from doorman.kinematics.urdf.robot import load_pinocchio
from doorman.kinematics.urdf.structure import check_structure
from doorman.kinematics.vehicles.vehicle import Vehicle
from doorman.model import Model
from doorman.scenario import DoorSection, Scenario, VehicleSection

LEAF_BOX = (
    '<origin xyz="0.6 -0.02 0.8" rpy="0 0 0"/>\n      <geometry><box size="1.2 0.04 1.6"/></geometry>\n    </collision>'
)
DISC = '<geometry><cylinder radius="0.40" length="0.0004"/></geometry>'
ELBOW = '<joint name="eta_3" type="revolute">'

# name, text of the shipped file (every occurrence is replaced), what stands there instead, field, given
DOORS = [
    ("leaf renamed", '"leaf"', '"slab"', "door.leaf", "leaf"),
    ("leaf dangling", '<link name="leaf">', '<link name="panel">', "joint[hinge]/child@link", "leaf"),
    ("hinge renamed", '"hinge"', '"pivot"', "door.hinge", "hinge"),
    ("hinge fixed", 'type="revolute"', 'type="fixed"', "door.hinge", "hinge"),
    ("hinge of no type", 'type="revolute"', "", "joint[hinge]@type", ""),
    ("hinge of unknown type", 'type="revolute"', 'type="rotary"', "joint[hinge]@type", "rotary"),
    ("axis zero", '<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', "joint[hinge]/axis@xyz", "0 0 0"),
    ("axis NaN", '<axis xyz="0 0 1"/>', '<axis xyz="0 0 nan"/>', "joint[hinge]/axis@xyz", "0 0 nan"),
    ("axis in a plane", '<axis xyz="0 0 1"/>', '<axis xyz="0 1"/>', "joint[hinge]/axis@xyz", "0 1"),
    ("hinge turned", 'xyz="0 0 0.4" rpy="0 0 0"', 'xyz="0 0 0.4" rpy="0 0 0.3"', "joint hinge", "a jamb at"),
    ("hinge limits swapped", 'lower="-1.5" upper="1.5708"', 'lower="1.5708" upper="-1.5"', "joint hinge/limit@upper", -1.5),
    ("hinge without limits", '<limit lower="-1.5" upper="1.5708" effort="0" velocity="10"/>', "", "joint hinge/limit@upper", 0.0),
    ("leaf without mass", '<mass value="11"/>', '<mass value="0"/>', "link leaf/inertial/mass", 0.0),
    ("mass NaN", '<mass value="11"/>', '<mass value="nan"/>', "link[leaf]/inertial/mass@value", "nan"),
    ("mass in words", '<mass value="11"/>', '<mass value="heavy"/>', "link[leaf]/inertial/mass@value", "heavy"),
    ("mass without value", '<mass value="11"/>', "<mass/>", "link[leaf]/inertial/mass@value", "none"),
    ("mass left out", '<mass value="11"/>', "", "link[leaf]/inertial", "none"),
    ("inertia NaN", 'izz="1.32"', 'izz="NaN"', "link[leaf]/inertial/inertia@izz", "NaN"),
    ("inertia left out", 'izz="1.32"', "", "link[leaf]/inertial/inertia@izz", "none"),
    ("inertia negative", 'izz="1.32"', 'izz="-9"', "link leaf/inertial/inertia", -5.04),
    ("leaf without box", LEAF_BOX, LEAF_BOX.replace('<box size="1.2 0.04 1.6"/>', '<sphere radius="1"/>'),
     "link leaf/collision", "no shape with edges"),
    ("leaf without shape", LEAF_BOX, LEAF_BOX.replace('<box size="1.2 0.04 1.6"/>', ""),
     "link[leaf]/collision[leaf]/geometry", 0),
    ("leaf without geometry", LEAF_BOX, '<origin xyz="0 0 0"/></collision>', "link[leaf]/collision[leaf]", "none"),
    ("box of two sizes", LEAF_BOX, LEAF_BOX.replace("1.2 0.04", "1.2"), "collision[leaf]/geometry/box@size", "1.2 1.6"),
    ("box without width", LEAF_BOX, LEAF_BOX.replace("1.2 0.04", "0 0.04"), "geometry/box@size", "0 0.04 1.6"),
    ("negative damping", 'damping="0.0"', 'damping="-1"', "joint[hinge]/dynamics@damping", "-1"),
    ("two leaves", '<link name="leaf">', '<link name="leaf"/><link name="leaf">', "/robot[hinged_door]/link@name", "leaf"),
    ("loose link", '<link name="leaf">', '<link name="mat"/><link name="leaf">', "/robot[hinged_door]/link", "roots"),
    ("hinge in a loop", '<parent link="frame"/>', '<parent link="leaf"/>', "/robot[hinged_door]/link", "loop"),
    ("frame missing", '<parent link="frame"/>', '<parent link="wall"/>', "joint[hinge]/parent@link", "wall"),
    ("robot without name", ' name="hinged_door"', "", "/robot@name", ""),
    ("leaf hung twice", '<joint name="hinge"',
     '<joint name="second" type="fixed"><parent link="frame"/><child link="leaf"/></joint><joint name="hinge"',
     "joint[hinge]/child@link", "leaf"),
]  # fmt: skip
VEHICLES = [
    ("joint's name with a line break", '"eta_3"', '"eta\n_3"', "/robot", "'eta\\n_3'"),
    ("base link renamed", '"base_link"', '"body"', "vehicle.base_link", "base_link"),
    ("base link dangling", '<link name="base_link">', '<link name="body">', "joint[rotor_1]/parent@link", "base_link"),
    ("tip renamed", '"tip"', '"finger"', "vehicle.tip", "tip"),
    ("joint floating", ELBOW, ELBOW.replace("revolute", "floating"), "joint eta_3", "floating"),
    ("tip of another tree", '<link name="tip">', '<link name="tip"/><link name="free">', "/link", "free"),
    ("joint that follows", ELBOW, ELBOW + '<mimic joint="eta_2"/>', "joint eta_3/mimic", "eta_2"),
    ("joint that stands", 'effort="3.1" velocity="3.1"', 'effort="3.1" velocity="0"', "joint eta_1/limit@velocity", 0.0),
    ("joint backwards", 'velocity="3.1"', 'velocity="-3.1"', "joint eta_1/limit@velocity", 0.0),
    ("limits swapped", 'lower="-1.80" upper="1.80"', 'lower="1.80" upper="-1.80"', "joint eta_4/limit@upper", -1.8),
    ("vehicle without mass", '<mass value="3.0"/>', '<mass value="0"/>', "link base_link/inertial/mass", 0.0),
    ("vehicle of negative mass", '<mass value="3.0"/>', '<mass value="-3"/>', "link[base_link]/inertial/mass@value", "-3"),
    ("inertia of a needle", 'ixx="0.045"', 'ixx="0"', "link base_link/inertial/inertia", [0.0, 0.045, 0.08]),
    ("rotor that pushes down", 'effort="8.0"', 'effort="-8"', "joint[rotor_1]/limit@effort", "-8"),
    ("disc of no radius", DISC, DISC.replace("0.40", "0"), "link[base_link]/collision/geometry/cylinder@radius", "0"),
    ("disc of a lost mesh", DISC, '<geometry><mesh filename="lost.stl"/></geometry>', "vehicle.radius", "lost.stl"),
    ("tip half a frame", '<origin xyz="0.25 0 0" rpy="0 0 0"/>', '<origin xyz="0.25"/>', "joint[tip_mount]/origin@xyz", "0.25"),
]  # fmt: skip
FILES = [
    ("empty", b"", "XML", "no element found"),
    ("cut off", DOOR.read_bytes()[:2000], "XML", "line"),
    ("not XML", b"robot: door", "XML", "syntax error"),
    ("binary", bytes(range(256)), "XML", "not well-formed"),
    ("unknown encoding", b'<?xml version="1.0" encoding="klingon"?><robot/>', "XML", "klingon"),
    ("encoding of many bytes", b'<?xml version="1.0" encoding="utf-7"?><robot/>', "XML", "encodings"),
    ("another root", b"<sdf><model/></sdf>", "root element", "sdf"),
    ("no links", b'<robot name="nothing"/>', "/robot[nothing]/link", "roots none"),
]


def check(error: UrdfError, path: Path, field: str, given: object) -> None:
    """All four parts are there, and say what they should."""
    assert error.file == str(path)
    assert error.field is not None
    assert error.field.endswith(field)
    assert error.allowed
    if isinstance(given, str):
        assert given in str(error.given)
    else:
        assert error.given == (pytest.approx(given) if isinstance(given, float) else given)
    assert str(path) in str(error)
    assert field in str(error)


def edited(tmp_path: Path, source: Path, old: str, new: str) -> Path:
    text = source.read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / source.name
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


CASES = [*((Door, DOOR, *case) for case in DOORS), *((Vehicle, VEHICLE, *case) for case in VEHICLES)]


@pytest.mark.parametrize(
    ("reader", "source", "old", "new", "field", "given"), [(*case[:2], *case[3:]) for case in CASES],
    ids=[case[2] for case in CASES],
)  # fmt: skip
def test_a_broken_urdf_is_refused(
    reader: object, source: Path, old: str, new: str, field: str, given: object, tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    path = edited(tmp_path, source, old, new)
    with pytest.raises(UrdfError) as caught:
        reader(path)  # type: ignore[operator]
    check(caught.value, path, field, given)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("content", "field", "given"), [case[1:] for case in FILES], ids=[case[0] for case in FILES])
@pytest.mark.parametrize("reader", [load_pinocchio, Door, Vehicle])
def test_what_is_not_a_urdf(reader: object, content: bytes, field: str, given: str, tmp_path: Path) -> None:
    path = tmp_path / "broken.urdf"
    path.write_bytes(content)
    with pytest.raises(UrdfError) as caught:
        reader(path)  # type: ignore[operator]
    check(caught.value, path, field, given)


def test_an_encoding_that_xml_has_is_read(tmp_path: Path) -> None:
    (tmp_path / "door.urdf").write_bytes(DOOR.read_text(encoding="utf-8").encode("utf-16"))
    assert Door(tmp_path / "door.urdf").mass == Door(DOOR).mass


@pytest.mark.parametrize("reader", [load_pinocchio, Door, Vehicle])
@pytest.mark.parametrize("name", ["absent.urdf", "."])
def test_missing_file(reader: object, name: str, tmp_path: Path) -> None:
    with pytest.raises(UrdfError) as caught:
        reader(tmp_path / name)  # type: ignore[operator]
    check(caught.value, tmp_path / name, "file", str(tmp_path / name))


@pytest.mark.parametrize(
    ("section", "field", "given"),
    [
        (VehicleSection(tip="base_link"), "vehicle.tip", "base_link"),
        (VehicleSection(tip="rotor_1"), "vehicle.tip", "rotor_1"),
        (VehicleSection(base_link="servo_1"), "vehicle.tip", "tip"),
        (VehicleSection(base_link="eta_1"), "vehicle.base_link", "eta_1"),
        (DoorSection(leaf="frame"), "door.leaf", "frame"),
        (DoorSection(leaf="hinge"), "door.leaf", "hinge"),
        (DoorSection(hinge="leaf"), "door.hinge", "leaf"),
    ],
)
def test_names_that_do_not_fit(section: VehicleSection | DoorSection, field: str, given: object) -> None:
    with pytest.raises(UrdfError) as caught:
        Door(DOOR, section) if isinstance(section, DoorSection) else Vehicle(VEHICLE, section)
    check(caught.value, DOOR if isinstance(section, DoorSection) else VEHICLE, field, given)


def test_urdfs_swapped() -> None:
    with pytest.raises(UrdfError, match=r"base_link.*allowed: frame, leaf"):
        Vehicle(DOOR)
    with pytest.raises(UrdfError, match=r"leaf.*allowed: base_link, servo_1"):
        Door(VEHICLE)


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
