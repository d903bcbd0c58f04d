"""The task: door, contact with it, start and goal, and the mission between them."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator, model_validator

from doorman.scenario.values import Angle, DoorAngle, Name, NonNegative, Number, Pitch, Positive, Section, Switch

_PLACES = ("frame", "link", "point")
"""Keys of `[contact]` that name a place on the leaf."""
_NAMES = {"joint": "hinge", "link": "leaf"}
"""Other names of keys of `[door]`."""


class LatchSection(Section):
    """Latch that holds the door until a lever, a knob or a handle has been turned."""

    joint: Name
    """Joint of the door's URDF that opens it."""
    opens_at: Positive
    """How far that joint must be from `closed` for the door to be free [rad, or m]."""
    holds: Positive = 30.0
    """Torque, or force, up to which the latch holds the door [N m, or N]."""
    closed: Number = 0.0
    """Value of that joint where nothing turns it [rad, or m]."""


class BesideSection(Section):
    """Another joint of the door's URDF, which moves in the simulated plant and stands still for the plans of this task."""

    joint: Name
    """Its name."""
    value: Number = 0.0
    """Where it stands [rad, or m]."""
    closed: Number = 0.0
    """Where nothing turns it [rad, or m]."""
    damping: NonNegative | None = None
    """b [N m s/rad, or N s/m]. Default: from the URDF."""
    friction: NonNegative | None = None
    """τ_c [N m, or N]. Default: from the URDF."""
    stiffness: NonNegative = 0.0
    """k of its spring [N m/rad, or N/m]."""
    preload: NonNegative = 0.0
    """Torque, or force, with which it is drawn back to `closed` [N m, or N]."""


class DoorSection(Section):
    """Door: its URDF, the names in it, and the torques in its hinge. `link` and `joint` are other names of `leaf` and `hinge`."""

    urdf: Name = "hinged_door"
    """Name of a shipped URDF, or a path relative to the scenario's file."""
    leaf: Name = "leaf"
    """Link of the leaf; `link` is another name of this key."""
    hinge: Name = "hinge"
    """Joint of the hinge; `joint` is another name of this key."""
    closed: Angle | None = None
    """Value of that joint where the door is closed; urdf/README.md#doors-of-your-own says how it is found [rad, or m].
    Default: where the leaf's free edge meets a jamb; of a slide 0, or the end nearer to it."""
    width: Positive | None = None
    """D_w, width of the leaf; leaf and frame are stretched to it (a door of frame and leaf, without meshes) [m].
    Default: from the URDF."""
    mass: Positive | None = None
    """Mass of the leaf, its inertia in proportion (the same doors) [kg]. Default: from the URDF."""
    frame_height: Positive | None = None
    """Height of the frame's opening above the leaf's lower edge; disc and arm stay below it [m]. Default: from the URDF."""
    damping: NonNegative | None = None
    """b, viscous damping of the hinge [N m s/rad]. Default: from the URDF."""
    friction: NonNegative | None = None
    """τ_c, Coulomb friction of the hinge [N m]. Default: from the URDF."""
    friction_rate: ClassVar = 0.02
    """ε in τ_c tanh(α̇/ε) [rad/s]."""
    stiffness: NonNegative = 0.0
    """k of a spring or closer [N m/rad]."""
    rest_angle: Angle = math.pi / 2
    """α_0, where the spring is relaxed [rad]."""
    preload: NonNegative = 0.0
    """τ_p, torque with which a closer shuts the door at any opening [N m]."""
    stiction: NonNegative = 0.0
    """τ_s, torque by which a standing hinge resists more than a moving one [N m]."""
    position: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
    """Where the origin of the URDF is, world frame; `doorman vehicle door` measures and writes it [m]."""
    yaw: Angle = 0.0
    """Angle by which the door is turned about the vertical through that origin; written with `position` [rad]."""
    search: ClassVar = 0.1
    """Distance from the map up to which a sensor of the door's frame moves the door; beyond it the vehicle does not fly [m]."""
    search_yaw: ClassVar = math.radians(10.0)
    """Angle up to which such a sensor turns it [rad]."""
    latched: Switch = False
    """Whether a latch or a lock holds the door; the check refuses such a door. Written as `false`, it says
    that a lever on the leaf opens no latch: it stands still."""
    latch: LatchSection | None = None
    """Latch that a lever or a knob opens, which `first` turns (docs/handle.md). Default: none."""
    beside: tuple[BesideSection, ...] = ()
    """Other joints that move in the simulated plant; `first` fills it in."""

    @model_validator(mode="before")
    @classmethod
    def _other_names(cls, values: Any) -> Any:
        """`joint` and `link`, in place of `hinge` and `leaf`."""
        if not isinstance(values, dict):
            return values
        return {_NAMES.get(key, key): value for key, value in values.items() if key not in _NAMES} | {
            _NAMES[key]: value for key, value in values.items() if key in _NAMES
        }


class ContactSection(Section):
    """Where and how the tip touches the leaf."""

    distance_from_hinge: Positive = 0.70
    """D_V, at most the leaf's width, and by default at most 85 % of it; without `frame`, a slide is touched in the middle
    of its face. A tip that pushes comes nearer to the hinge where the doorway is too narrow to stand behind it all the way. Where
    the disc would come within 4 cm of the margin to the latch jamb, the goal's heading lies up to 14° beside the normal [m]."""
    height: NonNegative = 0.80
    """D_H above the lower end of the hinge line, at most the leaf's height, and by default at most 85 % of it; a leaf whose
    hinge lies is touched in the middle of its width [m]."""
    kind: Literal["grip", "push"] = "grip"
    """`"grip"`: tip and leaf are tied, as the paper assumes; `"push"`: the tip can only push, and moves a leaf away
    from the vehicle, on any hinge or slide (docs/push.md)."""
    frame: Name | None = None
    """Frame of the door's URDF, on the leaf, where the tip touches; its x axis points away from the leaf, within 5° of
    the leaf's normal. It takes the place of `distance_from_hinge`, `height` and `side`. Default: none."""
    link: Name | None = None
    """Link of the door's URDF on the leaf, such as a handle, that the tip touches in the middle of its outer side. In place of
    `frame`. Default: none."""
    point: tuple[Number, Number, Number] | None = None
    """Where the tip touches, in the frame of the leaf's link [m]. In place of `frame`. Default: none."""
    normal: tuple[Number, Number, Number] | None = None
    """Direction away from the leaf at `point`, in the frame of the leaf's link, of any length. Default: that of the face."""
    side: Literal["push", "pull"] | None = None
    """Side of the leaf that the vehicle is on: `"push"`, from which the door is pushed open, or `"pull"`. Default: that of
    `frame`, `link` or `normal`; else of a start or goal whose `door_angle` is beyond π/2; else `"pull"` of a slide, and `"push"`
    of a hinge."""
    friction: Positive = 0.6
    """μ between tip and leaf that a plan counts on."""

    @property
    def named(self) -> str | None:
        """The key that says where the URDF has the contact: `frame`, `link` or `point`."""
        return next((key for key in _PLACES if getattr(self, key) is not None), None)

    @model_validator(mode="after")
    def _one_place(self) -> ContactSection:
        given = [key for key in _PLACES if getattr(self, key) is not None]
        if len(given) > 1:
            raise ValueError(f"one of contact.{', contact.'.join(_PLACES)}")
        if self.normal is not None and (self.point is None or not any(self.normal)):
            raise ValueError("contact.normal: a direction, beside contact.point")
        return self


class StartSection(Section):
    """Where the task starts, at rest. What is not given of its posture is found (`doorman.postures`)."""

    attitude: tuple[Angle, Pitch, Angle] | None = None
    """Roll, pitch and yaw at the start [rad]. Default: found, see below."""
    door_angle: DoorAngle | None = None
    """α at the start; it falls as a door is pushed open, and grows as one is pulled [rad]. Default: π/2, closed."""
    opening: NonNegative | None = None
    """How far the door is open at the start, from either side; a slide has no `door_angle` [rad, or m]. Default: in
    place of `door_angle`."""
    arm: tuple[Angle, ...] | None = None
    """H at the start, n angles [rad]. Default: found, see below."""


class GoalSection(Section):
    """Where the task ends, at rest. What is not given of its posture is found (`doorman.postures`)."""

    attitude: tuple[Angle, Pitch, Angle] | None = None
    """Roll, pitch and yaw at the goal [rad]. Default: found, see below."""
    door_angle: DoorAngle | None = None
    """α at the goal [rad]. Default: that of an opening of 70°, or of the hinge's limit."""
    opening: NonNegative | None = None
    """How far the door is open at the goal, from either side; 0 shuts it [rad, or m]. Default: in place of
    `door_angle`; of a slide 0.3 m, or its limit."""
    arm: tuple[Angle, ...] | None = None
    """H at the goal, n angles [rad]. Default: found, see below."""
    duration: Literal["safe"] | Positive = "safe"
    """How long the opening should take, from the touch until the door is within 2° of the goal; or `"safe"`, as fast as is safe
    (docs/theory.md#how-fast-a-leaf-goes) [s]."""

    @field_validator("duration", mode="before")
    @classmethod
    def _time_or_safe(cls, value: Any) -> Any:
        if value != "safe" and (
            isinstance(value, bool) or not isinstance(value, (int, float)) or not 0.0 < value < math.inf
        ):
            raise ValueError('a time > 0 [s], or "safe"')
        return value


class MissionTimeOutsSection(Section):
    """Longest time of every phase [s]."""

    approach: ClassVar = 20.0
    """Until the tip is 6 cm before the leaf [s]."""
    open: Positive = 60.0
    """Until the door stands at the goal, after every touch [s]."""
    hold: Positive = 60.0
    """On a vehicle: time for a person to take a door that would not stay; then the vehicle leaves [s]."""


class MissionSection(Section):
    """From hover to hover."""

    start: Literal["hover", "contact"] = "hover"
    """`"hover"`: away from the door; `"contact"`: with the tip on the leaf."""
    then: Literal["return", "stay", "through"] = "return"
    """What follows at the goal: `"return"` to a hover before the door, `"stay"` with the tip on the leaf, which holds
    it, or `"through"` the doorway to a hover 1 m behind it. With `"stay"` a simulated mission ends there; a vehicle
    holds the door for `time_out.hold`."""
    hover_distance: Positive = 0.6
    """Distance between tip and leaf before the approach [m]."""
    measures: tuple[Literal["poses", "attitude", "frame"], ...] = ("poses", "attitude")
    """What a mission measures from the hover before the door: `"poses"`, their age and noise; `"attitude"`, lag, dead time and
    shape of the attitude loop, by steps of 1.7° in 4 s, which plans and controllers count on in place of `vehicle.attitude_lag`;
    `"frame"`, where a door stands that is to be pushed: the tip first touches wall and frame beside it. The flight gives up where
    contact would not bear such poses, or such a loop was never tested."""
    approach_speed: ClassVar = 0.15
    """Speed of the approach [m/s]."""
    touch_speed: ClassVar = 0.04
    """Speed of the touch [m/s]."""
    hold_time: ClassVar = 1.0
    """Time for which the door must stay at the goal before the vehicle lets it go [s]."""
    hold_open: ClassVar = 3.0
    """Time for which the vehicle holds a door whose closer would shut it on the vehicle [s]."""
    recoveries: ClassVar = 20
    """Largest number of losses of contact in an attempt."""
    attempts: Annotated[int, Field(strict=True, ge=1, le=10)] = 2
    """1 to 10: largest number of attempts from the hover; after a failure that may not happen again, the vehicle backs
    out and comes again."""
    time_out: MissionTimeOutsSection = MissionTimeOutsSection()
