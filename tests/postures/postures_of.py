"""Random tasks, and the width of a posture by Pinocchio instead of the kernels."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from paper_door import door_normal, leaf_direction
from urdf_variants import VEHICLE, write_arm, write_arm_of, write_edited

from doorman.kinematics.coupling import BESIDE
from doorman.kinematics.rotations import rotation_body_to_world
from doorman.model import Model
from doorman.scenario import Scenario


def random_task(folder: Path, seed: int) -> Model:
    """Another arm of 2 to 7 joints, contact point, goal angle and margin; every second tip can only push."""
    rng, n, odd = np.random.default_rng(seed), 2 + seed % 6, seed % 4 > 1
    path = folder / "arm.urdf"
    if n == 4 and not odd:
        write_arm(path, rod=rng.uniform(0.2, 0.5))
    else:
        write_arm_of(path, n, odd_axes_seed=seed if odd else None)
    overrides: dict[str, Any] = {
        "vehicle.urdf": str(path),
        "goal.door_angle": rng.uniform(0.1, 1.4),
        "contact.distance_from_hinge": rng.uniform(0.45, 1.0),
        "planner.margin": rng.uniform(0.0, 0.04),
    }
    if odd:  # short arms
        overrides["vehicle.radius"] = 0.25
    return Model(Scenario.load(("paper", "push")[seed % 2], overrides))


def width(model: Model, state: np.ndarray) -> float:
    """Least distance of a posture from constraints, joint limits, singularity and, for a tip that pushes, skew."""
    vehicle, arm, rotation = model.vehicle, state[5:], rotation_body_to_world(state[:3])
    span, normal, tip = vehicle.upper_limits - vehicle.lower_limits, door_normal(state[3]), vehicle.tip_position(arm)
    radius, across = model.vehicle.radius, float((rotation @ tip)[1])
    contact = model.coupling.distance_from_hinge * math.sin(state[3])
    margins = [
        *-vehicle.point_positions(arm)[:, 2],
        float(normal @ rotation @ tip) - radius * math.hypot(*(rotation.T @ normal)[:2]),
        model.door.width - radius - (contact - across),
        contact - across - radius,
    ]
    distances = [min(margins) - model.scenario.planner.margin, *((arm - vehicle.lower_limits) / span)]
    distances += [
        *((vehicle.upper_limits - arm) / span),
        np.linalg.norm(vehicle.tip_jacobian(arm).T @ rotation.T @ normal),
    ]
    if model.scenario.contact.kind == "push":
        aside = abs(leaf_direction(state[3]) @ rotation @ tip)
        distances.append(math.tan(BESIDE) * float(normal @ rotation @ tip) - aside)
    return float(min(distances))


def widest_of_samples(model: Model, state: np.ndarray, count: int, above: float, seed: int) -> float:
    """Width of the widest of random level postures at a state's door angle; −∞ where none is wider than `above`."""
    rng = np.random.default_rng(seed)
    samples = np.tile(state, (count, 1))
    samples[:, :2] = 0.0
    samples[:, 2] = state[3] - math.pi / 2 + rng.uniform(-math.pi, math.pi, count)
    samples[::2, 2] = state[3] - math.pi / 2 + rng.uniform(-0.6, 0.6, len(samples[::2]))
    samples[:, 5:] = rng.uniform(model.vehicle.lower_limits, model.vehicle.upper_limits, (count, model.n_arm))
    rough = -(model.constraints_along(samples).max(axis=1) + model.scenario.planner.margin)
    return max((width(model, sample) for sample in samples[rough > above]), default=-math.inf)


def write_wrist(path: Path, axis: str = "0 -1 0") -> Path:
    """Write the shipped vehicle with a fifth joint half-way along the rod that carries the tip."""
    half, link = 0.125, '<link name="servo_5"><collision><origin xyz="0.060 0 0" rpy="0 1.570796 0"/><geometry>'
    link += '<cylinder radius="0.0004" length="0.110"/></geometry></collision></link>'
    joint = (
        f'<joint name="eta_5" type="revolute"><origin xyz="{half} 0 0"/><parent link="servo_4"/><child link="servo_5"/>'
        f'<axis xyz="{axis}"/><limit lower="-1.8" upper="1.8" effort="3.1" velocity="3.1"/></joint>'
    )
    rod = '<origin xyz="0.120 0 0" rpy="0 1.570796 0"/>\n      <geometry><cylinder radius="0.0004" length="0.240"/>'
    half_rod = rod.replace("0.120 0 0", "0.060 0 0").replace('length="0.240"', 'length="0.110"')
    mount = (
        '<joint name="tip_mount" type="fixed">\n    <origin xyz="0.25 0 0" rpy="0 0 0"/>\n    <parent link="servo_4"/>'
    )
    wrist = mount.replace("0.25 0 0", f"{half} 0 0").replace("servo_4", "servo_5")
    return write_edited(path, VEHICLE, (rod, half_rod), (mount, f"{link}{joint}{wrist}"))
