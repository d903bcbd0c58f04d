"""How noisy poses may be for a tip that pushes: the formula against an observer, and who refuses."""

from __future__ import annotations

import numpy as np
import pytest

from doorman.control.estimation.pose_noise import force_noise, most_force_noise, velocity_noise
from doorman.feasibility.inputs.setup import setup_findings
from doorman.feasibility.report import Finding
from doorman.flight import Verdict
from doorman.flight.ground.judgements import judge_noise
from doorman.hardware.mocap.faults import Figures
from doorman.model import Model
from doorman.scenario import Scenario


@pytest.mark.parametrize(("latency", "interval"), [(0.0, 0.004), (0.02, 0.008), (0.04, 0.01), (0.06, 0.02)])
@pytest.mark.parametrize("noise", [5e-4, 2e-3])
def test_the_velocitys_noise_is_that_of_a_filter_in_its_steady_state(
    noise: float, latency: float, interval: float
) -> None:
    """Place and velocity of a vehicle in rough air, by Riccati's recursion; then nothing is known for a while."""
    rough, moves = 0.025, np.array([[1.0, interval], [0.0, 1.0]])
    covariance = np.eye(2)
    for _ in range(5000):
        covariance = moves @ covariance @ moves.T + np.diag([0.0, rough**2 * interval])
        gain = covariance[:, 0] / (covariance[0, 0] + noise**2)
        covariance = covariance - np.outer(gain, covariance[0])
    known = np.sqrt(covariance[1, 1] + rough**2 * latency)
    assert velocity_noise(noise, latency, interval, rough) == pytest.approx(known, rel=0.1)


def finding(source: str, **sensors: float) -> Finding | None:
    keys = {f"simulation.{name.replace('__', '.')}": value for name, value in sensors.items()}
    found = {one.name: one for one in setup_findings(Model(Scenario.load(source, keys)))}
    return found.get("noise of poses")


@pytest.mark.parametrize(
    ("position", "latency", "severity"),
    [(0.001, 0.02, "ok"), (0.001, 0.04, "ok"), (0.002, 0.04, "ok"), (0.004, 0.04, "error"), (0.006, 0.01, "error")],
)
def test_the_check_refuses_poses_too_noisy_to_push(position: float, latency: float, severity: str) -> None:
    keys = {"noise__position": position, "sensors__latency": latency, "sensors__rate": 100.0}
    found = finding("push", **keys)
    assert found is not None and found.severity == severity, found
    assert finding("paper", **keys) is None, "a grip loses no contact"


def test_the_checklist_refuses_what_the_check_refuses() -> None:
    model = Model(Scenario.load("push"))
    good, bad = (judge_noise(model, size, 0.04, 100.0) for size in (1e-3, 4e-3))
    assert (good.verdict, bad.verdict) == (Verdict.GOOD, Verdict.BAD) and "gripper" in bad.advice
    assert force_noise(model, 4e-3, 0.04, 0.01) > most_force_noise(model)
    assert judge_noise(model, float("nan"), 0.04, 100.0).verdict is Verdict.WARNING


@pytest.mark.parametrize("noise", [2e-4, 2e-3])
def test_the_noise_of_poses_is_measured_whatever_the_vehicle_does(noise: float) -> None:
    """It swings by 10 cm at half a hertz, and every tenth frame is missing."""
    figures, random = Figures(), np.random.default_rng(2)
    for frame in range(1200):
        if frame % 10:
            place = 0.1 * np.sin(np.pi * frame / 100.0) * np.ones(3)
            figures.pose(0.0, frame, (place + noise * random.standard_normal(3)).tolist())
    measured = figures.statistics({}, 100.0, 0.01).position_noise
    assert measured == pytest.approx(noise, rel=0.15)
    assert np.isnan(Figures().statistics({}, 100.0, 0.01).position_noise)
