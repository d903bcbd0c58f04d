"""Findings from the numbers of scenario and URDFs alone: masses, rotors, contact, limits, start and goal, planner."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.pose_age import oldest_pose
from doorman.control.estimation.pose_noise import force_noise, most_force_noise
from doorman.control.state_converter import LookAheads
from doorman.dynamics.attitude_loop import TESTED_LAG
from doorman.feasibility.inputs.bodies import body_findings
from doorman.feasibility.inputs.door import door_findings
from doorman.feasibility.inputs.hollow import hollow_findings
from doorman.feasibility.inputs.vehicle import vehicle_findings
from doorman.feasibility.lift import lift_findings
from doorman.feasibility.report import Finding, Severity, found, warning_if
from doorman.kinematics.doors.urdf.convention import ROUNDED
from doorman.model import Model

_MOST_BEFORE = 0.25
"""Share of the contact's distance from the hinge by which the face may stand before the axis."""
_CONTACT_EDGE = 0.02
_SHORTEST_HORIZON = 0.3
_LONGEST_STEP = 0.1
_NEARLY = 0.9
"""Share of the oldest pose's age from which the door ends farther from the goal."""


def setup_findings(model: Model) -> list[Finding]:
    """All findings that need no motion."""
    return [
        _latch(model),
        _contact_point(model),
        _leaf_surface(model),
        _hinge_limits(model),
        _doorway(model),
        _hinge_friction(model),
        *(_arm_limits(model, name) for name in ("start", "goal") if model.n_arm),
        *(_constraints_at(model, name) for name in ("start", "goal")),
        _planner_numbers(model),
        _age_of_poses(model),
        *_noise_of_poses(model),
        _attitude_lag(model),
        *body_findings(model),
        *lift_findings(model),
        *vehicle_findings(model),
        *door_findings(model),
        *hollow_findings(model),
    ]


def _latch(model: Model) -> Finding:
    """A latch that a person must turn first."""
    latched, latch = model.scenario.door.latched, model.scenario.door.latch
    advice = "unlock the door and remove door.latched from the scenario, or write door.latch and what is done first"
    if latch is not None and latch.joint != model.scenario.door.hinge and not latched:
        turned = [abs(each.value - latch.closed) for each in model.scenario.door.beside if each.joint == latch.joint]
        latched = not turned or turned[0] < latch.opens_at
        far = f" to {turned[0]:.2f} of {latch.opens_at:.2f}" if turned else ""
        advice = f"turn '{latch.joint}' first{far}: a step [[first]] of the scenario, docs/handle.md"
    message = f"{int(latched)} latches or locks hold the door"
    return found("latch", not latched, message, float(latched), 0.0, "latches", advice)


def _contact_point(model: Model) -> Finding:
    """The contact point against the leaf's edges; off the leaf is an error of the model already."""
    contact, door, distance = model.scenario.contact, model.door, model.coupling.distance_from_hinge
    if (door.slides or door.in_plane) and door.handle is not None:  # a narrow handle has its frame where it is gripped
        return found("contact on the leaf", True, f"contact.{contact.named} is on the leaf", None, None, "m")
    aside, height = (distance, door.width - distance), model.coupling.height
    sides = {"nearer": min(aside)} if door.slides else dict(zip(("hinge", "latch"), aside, strict=True))
    edges = {**sides, "lower": height, "upper": door.height - height}
    nearest = min(edges, key=lambda edge: edges[edge])
    fitted = ""
    if door.handle is None and not door.slides and distance < door.place_on_face(contact)[0]:
        fitted = f"; it is {distance:.2f} m from the hinge, so that the vehicle fits into the doorway behind the tip"
    return found(
        "contact on the leaf", edges[nearest] >= _CONTACT_EDGE,
        f"the contact point is {1e2 * edges[nearest]:.1f} cm from the leaf's {nearest} edge{fitted}",
        edges[nearest], _CONTACT_EDGE, "m", "move contact.distance_from_hinge or contact.height away from the edge",
        Severity.WARNING,
    )  # fmt: skip


def _leaf_surface(model: Model) -> Finding:
    """A push beside the hinge's axis, on a face that stands far before it, hardly turns the leaf."""
    offset, most = model.door.surface_offset, _MOST_BEFORE * model.coupling.distance_from_hinge
    return found(
        "leaf's surface", abs(offset) <= most, f"the leaf's face lies {1e3 * offset:.1f} mm before the hinge axis",
        offset, most, "m", f"move the face of the box of link '{model.door.section.leaf}' nearer to the hinge axis",
        Severity.WARNING,
    )  # fmt: skip


def _hinge_limits(model: Model) -> Finding:
    """Start and goal inside the hinge's limits."""
    door, lower, upper = model.door, model.door.lower_limit, model.door.upper_limit
    ends = sorted((lower, upper), key=door.opening_of if door.slides else None)
    angles = {"start": model.start_angle, "goal": model.goal_angle}
    inside, name = min((min(angle - lower, upper - angle), name) for name, angle in angles.items())
    ok, key = inside >= -ROUNDED, "opening" if door.slides else "door_angle"
    return found(
        "hinge limits", ok,
        f"the {name}'s {key.replace('_', ' ')} of {door.in_words(angles[name])} is {door.way_in_words(abs(inside))} "
        f"{'inside' if ok else 'outside'} the range of {' to '.join(map(door.in_words, ends))}",
        inside, 0.0, "rad", f"change {name}.{key}, or the limits of joint '{door.section.hinge}'",
    )  # fmt: skip


def _hinge_friction(model: Model) -> Finding:
    """The door observer finds the hinge's friction, up to its bound."""
    control, friction, words = model.scenario.control, model.door.friction, model.door.torque_in_words
    limit = control.max_door_disturbance if control.door_observer_rate > 0.0 else 0.0
    return found(
        "hinge friction", friction <= limit,
        f"of the joint's friction of {words(friction)} the door observer can find {words(limit)}", friction, limit, "N m",
        "raise control.max_door_disturbance, with a control.door_observer_rate > 0",
    )  # fmt: skip


def _doorway(model: Model) -> Finding:
    """Width of the doorway left beside the rotor disc; a vehicle that stays before the wall needs none."""
    if model.stays_before or model.door.side == "pull":
        return found("doorway width", True, "the vehicle stays before the wall", None, None, "m")
    margin, radius = model.scenario.planner.margin, model.vehicle.radius
    room = model.door.width - 2.0 * radius - 2.0 * margin
    return found(
        "doorway width", room > 0.0,
        f"the doorway of {model.door.width:.2f} m leaves {1e2 * room:.1f} cm beside a disc of "
        f"{2 * radius:.2f} m with a margin of {1e2 * margin:.1f} cm on either side",
        room, 0.0, "m", f"use a doorway wider by {-1e2 * room:.1f} cm, smaller rotors or a smaller planner.margin",
    )  # fmt: skip


class JointMargin(NamedTuple):
    """How far an arm stays from its limits."""

    joint: str  # the nearest one's name
    inside: float  # distance from the limit, negative outside [rad], or [m] where it slides
    unit: str

    @property
    def size(self) -> str:
        """Distance without its sign, in words."""
        inside = abs(self.inside)
        return f"{math.degrees(inside):.1f}°" if self.unit == "rad" else f"{1e2 * inside:.1f} cm"


def joint_margin(model: Model, arms: Array) -> JointMargin:
    """The least of many arm postures."""
    vehicle = model.vehicle
    inside = np.minimum(arms - vehicle.lower_limits, vehicle.upper_limits - arms).min(axis=0)
    worst = int(np.argmin(inside))
    return JointMargin(vehicle.joint_names[worst], float(inside[worst]), vehicle.angle_units[worst])


def _arm_limits(model: Model, name: str) -> Finding:
    """Arm posture of start or goal against the joint limits."""
    margin = joint_margin(model, np.array([model.start_arm if name == "start" else model.goal_arm]))
    joint, inside, unit = margin
    ok = inside >= 0.0
    return found(
        f"{name} arm", ok, f"joint {joint} of the {name}'s arm is {margin.size} {'inside' if ok else 'outside'} its limits",
        inside, 0.0, unit, f"move {name}.arm of joint {joint} by at least {-inside:.3f} {unit} towards the middle",
    )  # fmt: skip


def _constraints_at(model: Model, name: str) -> Finding:
    """Start or goal against the planner's constraints."""
    # A start inside the margin is left at once; a goal out of bounds makes the planner settle for a compromise, which the
    # rehearsal judges.
    margin = model.scenario.planner.margin
    h = model.constraints(model.start_state if name == "start" else model.goal_state)
    excess = h + margin
    worst = int(np.argmax(excess))
    broken = [f"'{model.constraint_names[k]}' by {1e2 * excess[k]:.1f} cm" for k in np.flatnonzero(excess > 0.0)]
    message = f"the {name} breaks {', '.join(broken)} (margin of {1e2 * margin:.1f} cm included)"
    if not broken:
        message = (
            f"the {name} keeps all constraints; the nearest, '{model.constraint_names[worst]}', "
            f"by {-1e2 * excess[worst]:.1f} cm beyond the margin of {1e2 * margin:.1f} cm"
        )
    attitude = " or goal.attitude" if name == "goal" else ""
    return found(
        f"{name} constraints", not broken, message, float(excess[worst]), 0.0, "m",
        f"change {name}.arm{attitude}, contact.distance_from_hinge or planner.margin",
        warning_if(name == "goal" or h[worst] <= 0.0),
    )  # fmt: skip


def _planner_numbers(model: Model) -> Finding:
    """Horizon, time step, latency and look-ahead of the planner against each other."""
    planner, ahead = model.scenario.planner, LookAheads.of(model.attitude_loop)
    horizon = planner.time_step * planner.horizon_steps
    look_ahead = max(ahead.position, ahead.acceleration + 2.0 * planner.time_step, ahead.attitude, ahead.arm)
    used = look_ahead + model.scenario.simulation.planner_latency_periods / planner.rate
    advice = ""
    if used >= horizon:
        advice = "raise planner.horizon_steps, or use a vehicle with less vehicle.attitude_lag"
    elif horizon < _SHORTEST_HORIZON:
        advice = "raise planner.horizon_steps: the door must be braked within the horizon"
    elif planner.time_step > _LONGEST_STEP:
        advice = "lower planner.time_step: constraints hold at nodes only"
    return found(
        "planner", not advice,
        f"a horizon of {horizon:.2f} s in steps of {planner.time_step:g} s, of which look-ahead and latency use {used:.2f} s",
        horizon, max(used, _SHORTEST_HORIZON), "s", advice, warning_if(used < horizon),
    )  # fmt: skip


def _attitude_lag(model: Model) -> Finding:
    """How far roll and pitch lag behind: the force on the leaf comes by them."""
    lag = model.attitude_loop.lag
    return found(
        "attitude lag", lag <= TESTED_LAG,
        f"roll and pitch lag {1e3 * lag:.0f} ms behind their setpoints; contact is tested up to {1e3 * TESTED_LAG:.0f} ms",
        lag, TESTED_LAG, "s", "tune the autopilot's attitude and rate loops, then doorman vehicle learn", Severity.WARNING,
    )  # fmt: skip


def _age_of_poses(model: Model) -> Finding:
    """The simulated cameras' poses, just before the next one comes; the checklist of a vehicle looks at the real ones."""
    sensors, limit = model.scenario.simulation.sensors, oldest_pose(model.scenario.control)
    age = sensors.latency + sensors.jitter + (0.0 if sensors.rate is None else 1.0 / sensors.rate)
    return found(
        "age of poses", age <= _NEARLY * limit,
        f"poses are up to {1e3 * age:.0f} ms old; contact is stable up to {1e3 * limit:.0f} ms with these gains",
        age, limit, "s",
        "use faster cameras (simulation.sensors.latency, rate), or smaller control.position_gain and velocity_gain",
        warning_if(age <= limit),
    )  # fmt: skip


def _noise_of_poses(model: Model) -> list[Finding]:
    """The force that the simulated cameras' noise makes at a tip that only presses."""
    simulation, limit = model.scenario.simulation, most_force_noise(model)
    if math.isinf(limit):
        return []
    sensors = simulation.sensors
    interval = 1.0 / (simulation.controller_rate if sensors.rate is None else sensors.rate)
    force = force_noise(model, simulation.noise.position, sensors.latency + sensors.jitter, interval)
    return [found(
        "noise of poses", force <= limit,
        f"noise of the poses moves the force at the tip by {force:.2f} N; the contact holds up to {limit:.2f} N",
        force, limit, "N",
        "use better or faster cameras (simulation.noise.position, simulation.sensors), or a gripper",
    )]  # fmt: skip
