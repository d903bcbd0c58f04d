r"""The simulated door: of another width than the planner knows, or elsewhere, or with its leaf elsewhere on the hinge.

Leaf, frame and wall stand at :math:`T = t(P_h + o)\,R_z(\psi)\,t(-P_h)` in the world, for the `door_offset` o and the `door_yaw`
ψ about the vertical through the lower end P_h of the hinge line. α stays the hinge's own angle.
"""

from __future__ import annotations

from pathlib import Path

from doorman.exceptions import UrdfError
from doorman.kinematics.doors.door import Door, Side
from doorman.kinematics.doors.variants.variant import write_door_with_face
from doorman.kinematics.urdf.elements import read_joints
from doorman.scenario import ContactSection, DoorSection, SimulationSection

_KEYS = ("door_width", "door_offset", "door_yaw", "door_face_offset")
"""Keys of `[simulation]` that make the true door differ from the planner's."""


class TrueDoor(Door):
    """Door as it truly is and where it truly stands. Threads may share it."""

    def __init__(
        self, urdf: Path, section: DoorSection, simulation: SimulationSection, side: Side = "push",
        contact: ContactSection | None = None,
    ) -> None:  # fmt: skip
        stretched = _with_width(urdf, section, simulation, side)
        super().__init__(*_with_face(stretched, simulation.door_face_offset), side, contact)
        self._stand(self.hinge_position, self.hinge_position + simulation.door_offset, simulation.door_yaw)


def is_another(simulation: SimulationSection) -> bool:
    """Whether the true door is another one than the planner knows."""
    default = SimulationSection()
    return any(getattr(simulation, key) != getattr(default, key) for key in _KEYS)


def _with_width(urdf: Path, section: DoorSection, simulation: SimulationSection, side: Side) -> Door:
    if simulation.door_width is None:
        return Door(urdf, section, side)
    try:
        return Door(urdf, section.model_copy(update={"width": simulation.door_width}), side)
    except UrdfError as error:
        error.field = "simulation.door_width"
        raise


def _with_face(door: Door, offset: float | None) -> tuple[Path, DoorSection]:
    """URDF and section of a door whose leaf stands elsewhere on the hinge."""
    section = door.section.model_copy(update={"width": None, "mass": None})  # the file has them already
    if offset is None:
        return door.urdf, section
    links, carried = door.link_placements(0.0), read_joints(door.urdf)[section.hinge].child
    towards_vehicle = links[carried][:3, :3].T @ -door.normal(0.0)
    return write_door_with_face(door.urdf, section.hinge, (offset - door.surface_offset) * towards_vehicle), section
