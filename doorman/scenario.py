"""Scenario: URDFs, contact, start, goal and options of one task, checked when read from TOML.

Every key has a default (the paper's task); an unknown key is an error that names its nearest neighbour. Angles are in rad,
everything else in SI units.
"""

from __future__ import annotations

import difflib
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, ValidationError, field_validator, model_validator

from doorman.exceptions import ScenarioError
from doorman.resources import scenario_directory, shipped, urdf_directory

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0)]
NonNegative = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0)]
Angle = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-2 * math.pi, le=2 * math.pi)]
DoorAngle = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-math.pi, le=math.pi)]
Pitch = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=-math.pi / 2, lt=math.pi / 2)]
Count = Annotated[int, Field(strict=True, ge=1, le=100_000)]
Name = Annotated[str, Field(min_length=1)]


class _Section(BaseModel):
    """A table of the TOML file: frozen, and closed to unknown keys."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class VehicleSection(_Section):
    """Vehicle: its URDF and the names in it."""

    urdf: Name = "hexarotor_arm"
    base_link: Name = "base_link"
    tip: Name = "tip"
    servos: tuple[Name, ...] | None = None
    """Frames of joints 3 … n; by default `servo_3` … `servo_n`."""
    radius: Positive | None = None
    """R_A [m]; by default the disc that holds all collision shapes fixed to the base link."""
    max_thrust: Positive | None = None
    """[N]; by default the sum over the URDF's rotors, or twice the weight where it names none."""


class DoorSection(_Section):
    """Door: its URDF, the names in it, and the torques in its hinge."""

    urdf: Name = "hinged_door"
    leaf: Name = "leaf"
    hinge: Name = "hinge"
    width: Positive | None = None
    """D_w [m]; leaf and frame are stretched to it. By default the URDF's."""
    mass: Positive | None = None
    """Of the leaf [kg], its inertia in proportion; by default the URDF's."""
    damping: NonNegative | None = None
    """b [N m s/rad]; by default the URDF's `<dynamics damping>`."""
    friction: NonNegative | None = None
    """τ_c [N m]; by default the URDF's `<dynamics friction>`."""
    friction_rate: Positive = 0.02
    """ε in τ_c tanh(α̇/ε) [rad/s]."""
    stiffness: NonNegative = 0.0
    """k of a spring or closer [N m/rad]."""
    rest_angle: Angle = math.pi / 2
    """α_0, where the spring is relaxed [rad]."""


class ContactSection(_Section):
    """Where and how the tip touches the leaf."""

    distance_from_hinge: Positive = 0.70
    height: NonNegative = 0.80
    kind: Literal["grip", "push"] = "grip"


class StartSection(_Section):
    """Where the task starts, at rest."""

    door_angle: DoorAngle = math.pi / 2
    arm: tuple[Angle, ...] | None = None
    """[rad]; by default [0, 1, −0.6, −0.4] for an arm of four joints, zeros for others."""


class GoalSection(_Section):
    """Where the task ends, at rest."""

    attitude: tuple[Angle, Pitch, Angle] = (0.0, 0.0, -7 * math.pi / 18)
    door_angle: DoorAngle = math.pi / 9
    arm: tuple[Angle, ...] | None = None
    """[rad]; by default [0, π/2, −π/2, 0] for an arm of four joints, zeros for others."""


class WeightsSection(_Section):
    """Diagonals of the cost; by default the paper's, extended to the arm's number of joints."""

    state: tuple[NonNegative, ...] | None = None
    terminal: tuple[NonNegative, ...] | None = None
    input: tuple[Positive, ...] | None = None


class PlannerSection(_Section):
    """Receding-horizon planner."""

    model: Literal["quasi_static", "lagrangian"] = "quasi_static"
    """The paper's simplified dynamics, or the full ones of vehicle and door."""

    time_step: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=0.5)] = 0.02
    horizon_steps: Annotated[int, Field(strict=True, ge=2, le=2000)] = 50
    rate: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=2000)] = 100.0
    iterations: Annotated[int, Field(strict=True, ge=1, le=100)] = 1
    """Iterations of `replan`; a cold plan iterates to convergence."""
    margin: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=0.5)] = 0.03
    """Tightens h ≤ 0 to h + margin ≤ 0 [m]."""
    weights: WeightsSection = WeightsSection()


class LimitsSection(_Section):
    """What the planner may ask of vehicle and arm; joint angles are the URDF's, the largest thrust the vehicle's."""

    enabled: Annotated[bool, Field(strict=True)] = True
    """Whether the limits are constraints of the plan."""
    min_thrust: NonNegative = 0.0
    """[N]."""
    body_rates: tuple[Positive, Positive, Positive] = (3.8, 3.8, 3.4)
    """Largest |Ω| about each axis [rad/s]."""
    joint_rates: Positive | None = None
    """Largest |Ḣ| of every joint [rad/s]; by default the URDF's."""
    tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=math.pi / 2)] = 0.6
    """Largest angle between the body's z axis and the vertical [rad]."""


class PushSection(_Section):
    """What a plan may ask of a tip that can only push (`contact.kind = "push"`)."""

    max_rate: Positive = 0.11
    """Largest rate of the door [rad/s]."""
    max_acceleration: Positive = 0.06
    """Largest acceleration of the door in the sense of opening [rad/s²]."""
    stopping_share: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=1)] = 0.3
    """η: share of the estimated resistance that a plan counts on to stop the door before the goal."""
    least_share: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, lt=1)] = 0.5
    """Least push, as a share of the estimated resistance; at most 1 − η, else the door cannot always be stopped."""
    least_force: Positive = 0.1
    """Least normal force of the tip, whatever the resistance [N]."""
    friction_coefficient: Positive = 0.6
    """μ between tip and leaf that a plan counts on."""
    max_yaw_torque: Positive = 0.12
    """Largest torque about the vertical by which the tip's force may turn the vehicle [N m]; rotors make little against it."""
    velocity_gain: Positive = 6.0
    """Impedance along the normal: force per difference of the tip's speed from the plan's [N s/m]."""
    hold_tolerance: Positive = 0.006
    """A gripped door that stands within this of the goal is open; unit of `hold_gain` [rad]."""
    hold_share: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, lt=1)] = 0.3
    """Share of the estimated friction by which a held door may still be pressed on: 0 is what closer and wind need alone."""
    hold_gain: NonNegative = 0.5
    """Change of the push while a held door is off by more than 0.8°, per tolerance [N/s]."""

    @model_validator(mode="after")
    def _can_brake(self) -> PushSection:
        if self.least_share + self.stopping_share > 1.0:
            raise ValueError("least_share + stopping_share <= 1, else a door cannot always be stopped")
        return self


class ControlSection(_Section):
    """Gains of the DOB position controller and of the state converter's look-ahead."""

    position_look_ahead: NonNegative = 0.04
    """The setpoints of position and velocity are the plan this long after the measured state [s]."""
    acceleration_look_ahead: NonNegative = 0.12
    """The same for the acceleration fed forward [s]."""
    attitude_look_ahead: NonNegative = 0.2
    """The same for yaw and for the force fed forward, which act through the attitude loop [s]."""
    arm_look_ahead: Positive = 0.1
    """Joint rates are those that reach the plan's posture this long after the measured state [s]."""
    engage_pitch: Positive = 0.1
    """At the start, the commanded pitch may differ from the measured one by this much [rad], and"""
    engage_rate: NonNegative = 0.2
    """by this much more for every second flown [rad/s]: with the tip tied, a jump would overload the arm's servos."""
    position_gain: tuple[Positive, Positive, Positive] = (4.0, 4.0, 6.0)
    """k_p [1/s²]."""
    velocity_gain: tuple[Positive, Positive, Positive] = (3.5, 3.5, 4.5)
    """k_d [1/s]."""
    observer_rate: Positive = 1.0
    """Bandwidth of the disturbance observer, 1/τ [rad/s]."""
    observer_damping: Positive = 2.0
    """a_1 of Q(s) = a_0/((τs)² + a_1 τs + a_0), a_0 = 1: 2 is critically damped."""
    max_disturbance: Positive = 10.0
    """Bound of the estimated disturbance, each axis [N]."""
    door_observer_rate: NonNegative = 2.0
    """Bandwidth of the observer of the unknown hinge torque [rad/s]; 0 switches it off."""
    max_door_disturbance: Positive = 5.0
    """Bound of that torque's estimate [N m]."""
    max_tilt: Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, lt=math.pi / 2)] = 0.25
    """[rad]."""


class ContactStateSection(_Section):
    """When the tip counts as pressing on the leaf."""

    touched_above: Positive = 0.35
    """Estimated normal force above which it touches [N],"""
    touched_after: NonNegative = 0.06
    """for so long [s],"""
    certain_above: Positive = 0.2
    """or, without delay, above this [N]"""
    certain_deviations: Positive = 5.0
    """and above so many standard deviations of the same estimate in free flight."""
    lost_below: NonNegative = 0.08
    """Estimated normal force below which contact is lost [N],"""
    lost_after: NonNegative = 0.05
    """for so long [s]."""


class EstimationSection(_Section):
    """Observer of the vehicle and filter of the door; prior values are pairs of mean and standard deviation."""

    vehicle_observer_rate: Positive = 15.0
    """Bandwidth of the observer of velocity and outer force [rad/s]."""
    wind_rate: Positive = 1.0
    """Bandwidth of the wind's estimate in free flight [rad/s]; in contact it fades to the average of free flight so fast."""
    angle_deviation: Positive = 0.01
    """Of the door's angle at the start [rad]."""
    angle_noise: Positive = 0.005
    """Of the angle that the tip measures [rad]."""
    push_noise: Positive = 0.5
    """Density of the push's noise in still air [N s^½],"""
    push_noise_in_wind: NonNegative = 0.2
    """and how it grows with the wind on the vehicle [s^½]."""
    torque_deviation: NonNegative = 0.05
    """Of torques in the hinge that come and go, in still air [N m],"""
    torque_deviation_in_wind: NonNegative = 0.15
    """and how it grows with the wind on the vehicle [m];"""
    torque_time: Positive = 2.0
    """their correlation time [s]."""
    leaf_wind: tuple[NonNegative, Positive] = (1.0, 0.5)
    """On the leaf, in the direction of the wind on the vehicle, where there is any [N];"""
    leaf_wind_share: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)] = 0.7
    """its mean is as much nearer to what the vehicle feels: 0 leaves it there, 1 expects the same on both."""
    leaf_wind_deviation: Positive = 0.25
    """Of the wind on the leaf in every direction [N]."""
    damping: tuple[NonNegative, Positive] = (0.7, 0.7)
    """b [N m s/rad]."""
    friction: tuple[NonNegative, Positive] = (0.8, 0.6)
    """τ_c [N m]."""
    stiffness: tuple[NonNegative, Positive] = (0.5, 0.7)
    """k, of a closer that is relaxed at the start [N m/rad]."""
    inertia_deviation: Positive = 0.5
    """Of I_D, as a share of the URDF's."""
    contact: ContactStateSection = ContactStateSection()


class MissionTimeOutsSection(_Section):
    """Longest time of every phase [s]."""

    hover: Positive = 15.0
    approach: Positive = 20.0
    touch: Positive = 30.0
    open: Positive = 60.0
    recover: Positive = 6.0
    release: Positive = 8.0
    retreat: Positive = 30.0


class MissionSection(_Section):
    """From hover to hover."""

    start: Literal["hover", "contact"] = "hover"
    """Where a flight begins: away from the door, or with the tip on the leaf."""
    hover_distance: Positive = 0.6
    """Between tip and leaf before the approach [m]."""
    approach_speed: Positive = 0.15
    """[m/s]."""
    touch_distance: Positive = 0.06
    """From here on the tip goes on at [m]"""
    touch_speed: Positive = 0.04
    """this speed [m/s]."""
    touch_force: Positive = 0.5
    """With which the tip presses after the touch [N]."""
    hold_time: Positive = 1.0
    """For which the door must stay at the goal before it is let go [s]."""
    hold_open: NonNegative = 3.0
    """For which a door is held whose closer would shut it on the vehicle; the mission ends there [s]."""
    recoveries: Annotated[int, Field(strict=True, ge=0, le=100)] = 8
    """How often contact may be lost before the opening is given up."""
    retreat_speed: Positive = 0.25
    """[m/s]."""
    time_out: MissionTimeOutsSection = MissionTimeOutsSection()


class NoiseSection(_Section):
    """Standard deviations of the simulated sensors' white noise."""

    position: NonNegative = 0.0005
    velocity: NonNegative = 0.005
    attitude: NonNegative = 0.001
    body_rates: NonNegative = 0.01
    arm_angles: NonNegative = 0.0005
    arm_rates: NonNegative = 0.005


class SensorsSection(_Section):
    """How the simulated motion capture delivers position, velocity and attitude."""

    latency: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)] = 0.0
    """Pose and arm come this long after they were true [s]; body rates do not."""
    rate: Positive | None = None
    """Poses per second, each held until the next; by default one at every tick of the controller."""
    dropout_rate: NonNegative = 0.0
    """Gaps without a new pose, per second without one."""
    dropout_duration: NonNegative = 0.2
    """Longest gap [s]; gaps are evenly spread from 0 to it."""
    velocity: Literal["measured", "differenced"] = "measured"
    """Velocity with noise of its own, or the difference of the last two noisy positions."""


class GustSection(_Section):
    """Wind in the simulation: a steady horizontal force that varies by chance."""

    vehicle: NonNegative = 0.0
    """Mean force on the vehicle [N]."""
    leaf: NonNegative = 0.0
    """Mean force on the leaf at half its width [N]; its share along the leaf's normal turns the door."""
    direction: Angle = 0.0
    """Towards which the wind blows, from the world's x axis about z [rad]."""
    variation: NonNegative = 0.15
    """Standard deviation of the force over its mean."""
    correlation_time: Positive = 1.0
    """Of the variation [s]."""


class SimulationSection(_Section):
    """Simulated plant."""

    physics_rate: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=500, le=20_000)] = 1000.0
    controller_rate: Annotated[float, Field(strict=True, allow_inf_nan=False, ge=20, le=2000)] = 250.0
    planner_latency_periods: Annotated[int, Field(strict=True, ge=0, le=20)] = 1
    """A plan is used this many planner periods after the state it starts from was measured."""
    motor_time_constant: NonNegative = 0.03
    """First-order lag of a rotor's thrust [s]."""
    torque_per_thrust: Positive = 0.016
    """Ratio of a rotor's drag torque to its thrust [m]."""
    tip_friction: NonNegative = 0.8
    """Coulomb coefficient between tip and leaf."""
    tip_stiffness: Positive = 2000.0
    """Compliance of a pushing tip [N/m]."""
    tip_damping: Positive = 60.0
    """[N s/m]."""
    grip_stiffness: Positive = 5000.0
    """Compliance of a gripping tip, in every direction [N/m]."""
    grip_damping: Positive = 100.0
    """[N s/m]."""
    door_damping: NonNegative | None = None
    """True damping of the hinge [N m s/rad]; by default what the planner is told."""
    door_friction: NonNegative | None = None
    """True Coulomb friction of the hinge [N m]; by default what the planner is told."""
    door_stiffness: NonNegative | None = None
    """True stiffness of a spring or closer [N m/rad]; by default what the planner is told."""
    door_rest_angle: Angle | None = None
    """Where that spring is relaxed [rad]; by default what the planner is told."""
    door_mass: Positive | None = None
    """True mass of the leaf [kg], its inertia in proportion; by default what the planner is told."""
    noise: NoiseSection = NoiseSection()
    sensors: SensorsSection = SensorsSection()
    gust: GustSection = GustSection()


class Distribution(_Section):
    """How one value of a campaign is drawn.

    Evenly between `min` and `max`, from a `choice`, with `mean` and `std`, or as another key is (`same_as`).
    """

    min: Number | None = None
    max: Number | None = None
    choice: Annotated[tuple[Any, ...], Field(min_length=1)] | None = None
    """Each entry as likely as the others."""
    mean: Number | None = None
    std: NonNegative | None = None
    """Of a normal distribution."""
    same_as: str | None = None
    """Another key that is drawn, whose value this one gets."""

    @model_validator(mode="after")
    def _one_form(self) -> Distribution:
        if {name for name, value in self if value is not None} not in (
            {"min", "max"}, {"choice"}, {"mean", "std"}, {"same_as"},
        ):  # fmt: skip
            raise ValueError("min and max, or choice, or mean and std, or same_as")
        if self.min is not None and self.max is not None and self.min > self.max:
            raise ValueError("min up to max")
        return self


class CampaignSection(_Section):
    """Many flights of the same task, each with values drawn by chance."""

    seed: Annotated[int, Field(strict=True, ge=0)] = 0
    """Of all draws; what run i draws depends on it and on i alone."""
    runs: Annotated[int, Field(strict=True, ge=1, le=1_000_000)] = 200
    """Number of flights."""
    duration: Positive | None = None
    """Longest flight [s]; by default each ends by itself."""
    time_out: Positive = 1800.0
    """Wall-clock time after which a flight is given up [s]."""
    low_friction: NonNegative = 0.5
    """Doors with less true friction in the hinge are reported by themselves too [N m]."""
    vary: dict[str, Distribution] = {}
    """What is drawn for every run, by dotted key of the scenario."""

    @field_validator("vary", mode="before")
    @classmethod
    def _dotted(cls, tables: Any) -> Any:
        return _flat(tables) if isinstance(tables, dict) else tables

    @field_validator("vary")
    @classmethod
    def _sources_are_drawn(cls, vary: dict[str, Distribution]) -> dict[str, Distribution]:
        drawn = [key for key, distribution in vary.items() if distribution.same_as is None]
        for key, distribution in vary.items():
            if distribution.same_as is not None and distribution.same_as not in drawn:
                raise ValueError(f"{key}: same_as one of {', '.join(drawn) or 'none, as no key is drawn by itself'}")
        return vary


def _flat(tables: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Distributions by dotted key, from nested tables: `a.b = {…}` is as good as `"a.b" = {…}`."""
    flat: dict[str, Any] = {}
    for key, value in tables.items():
        nested = isinstance(value, dict) and value and all(isinstance(item, dict) for item in value.values())
        flat |= _flat(value, f"{prefix}{key}.") if nested else {prefix + key: value}
    return flat


class Scenario(_Section):
    """One task: URDFs, contact, start, goal, and the options of planner, controller and simulator.

    Make one with `Scenario.load`; `Scenario()` is the paper's task.
    """

    vehicle: VehicleSection = VehicleSection()
    door: DoorSection = DoorSection()
    contact: ContactSection = ContactSection()
    start: StartSection = StartSection()
    goal: GoalSection = GoalSection()
    planner: PlannerSection = PlannerSection()
    limits: LimitsSection = LimitsSection()
    push: PushSection = PushSection()
    control: ControlSection = ControlSection()
    estimation: EstimationSection = EstimationSection()
    mission: MissionSection = MissionSection()
    simulation: SimulationSection = SimulationSection()
    campaign: CampaignSection = CampaignSection()

    _source: Path | None = PrivateAttr(default=None)

    @classmethod
    def load(cls, source: str | Path = "paper", overrides: Mapping[str, Any] | None = None) -> Scenario:
        """Read a scenario and check it.

        Args:
            source: Name of a shipped scenario (`paper`, `push`) or path of a TOML file.
            overrides: Values by dotted key, for example `{"contact.distance_from_hinge": 0.65}`; they win over the file.

        Returns:
            The checked scenario.

        Raises:
            ScenarioError: if the file is missing or malformed, or a key is unknown, of wrong type or out of range.
        """
        path = _find_scenario(source)
        try:
            tables = tomllib.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError) as error:  # syntax, encoding, integers or nesting beyond Python's limits
            raise ScenarioError(f"not valid TOML: {error}", file=path, allowed="TOML 1.0 in UTF-8") from error
        except OSError as error:
            raise ScenarioError(f"cannot be read: {error.strerror}", file=path) from error
        for key, value in (overrides or {}).items():
            _set(tables, key, value, path)
        try:
            scenario = cls.model_validate(tables)
        except ValidationError as error:
            raise _explain(cls, error, path) from None
        scenario._source = path
        return scenario

    @property
    def source(self) -> Path | None:
        """TOML file that this scenario was read from."""
        return self._source

    @property
    def name(self) -> str:
        """Name of the scenario's file without suffix."""
        return "default" if self._source is None else self._source.stem

    @property
    def vehicle_urdf(self) -> Path:
        """Path of the vehicle's URDF."""
        return self._urdf("vehicle.urdf", self.vehicle.urdf)

    @property
    def door_urdf(self) -> Path:
        """Path of the door's URDF."""
        return self._urdf("door.urdf", self.door.urdf)

    def _urdf(self, field: str, name: str) -> Path:
        known = shipped(urdf_directory(), ".urdf")
        if name.removesuffix(".urdf") in known:
            return known[name.removesuffix(".urdf")]
        bases = [Path.cwd()] if self._source is None else [self._source.parent, Path.cwd()]
        for base in bases:
            if (base / name).is_file():
                return (base / name).resolve()
        raise ScenarioError(
            "no such URDF",
            file=self._source,
            field=field,
            given=name,
            allowed=f"a shipped name ({', '.join(known)}) or a path relative to the scenario file",
        )


def _find_scenario(source: str | Path) -> Path:
    known = shipped(scenario_directory(), ".toml")
    if str(source) in known:
        return known[str(source)]
    path = Path(source)
    try:
        if path.is_file():
            return path.resolve()
    except OSError as error:
        raise ScenarioError(f"cannot be read: {error.strerror}", given=str(source)[:80]) from error
    close = difflib.get_close_matches(str(source), known, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    raise ScenarioError(
        f"no such scenario{hint}", given=str(source), allowed=f"{', '.join(known)}, or the path of a TOML file"
    )


def _set(tables: dict[str, Any], key: str, value: Any, path: Path) -> None:
    *sections, last = key.split(".")
    table = tables
    for section in sections:
        table = table.setdefault(section, {})
        if not isinstance(table, dict):
            raise ScenarioError(
                "not a table", file=path, field=key, given=section, allowed="a dotted key of the scenario"
            )
    table[last] = list(value) if isinstance(value, tuple) else value


_ALLOWED = {
    "model_type": "a table",
    "tuple_type": "a list",
    "missing": "a longer list",
    "too_long": "a shorter list",
    "string_too_short": "a name",
    "string_type": "a string",
    "float_type": "a number",
    "int_type": "an integer",
}
"""Words of TOML for what pydantic says in words of Python, by its type of error."""


def _explain(root: type[BaseModel], error: ValidationError, path: Path) -> ScenarioError:
    """Turn the first of pydantic's findings into one error of ours."""
    first = error.errors(include_url=False)[0]
    field = ".".join(str(part) for part in first["loc"])
    more = f" (and {error.error_count() - 1} more)" if error.error_count() > 1 else ""
    if first["type"] != "extra_forbidden":
        said = first["msg"].removeprefix("Input should be ").removeprefix("Value error, ")
        words = _ALLOWED.get(first["type"]) or said
        return ScenarioError(f"wrong value{more}", file=path, field=field, given=first["input"], allowed=words)
    section: type[BaseModel] = root
    for part in first["loc"][:-1]:
        section = _below(section, str(part))
    keys = list(section.model_fields)
    nearest = difflib.get_close_matches(str(first["loc"][-1]), keys, n=1, cutoff=0.0)[0]
    return ScenarioError(
        f"unknown key; the nearest is '{nearest}'{more}", file=path, field=field, allowed=", ".join(keys)
    )


def _below(section: Any, part: str) -> Any:
    """The section under a key, or the type of the values where a section maps names to sections."""
    return section.model_fields[part].annotation if hasattr(section, "model_fields") else get_args(section)[1]
