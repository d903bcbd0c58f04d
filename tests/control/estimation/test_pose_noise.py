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
def test_the_velocitys_noise_is_that_of_an_observer(latency: float, interval: float) -> None:
    """A vehicle that stands still, seen late and with noise: three poles, all at the bandwidth."""
    omega, random = min(15.0, 0.6 / latency) if latency else 15.0, np.random.default_rng(1)
    kept = np.exp(-omega * interval)
    lost, state, speeds = 1.0 - kept, np.zeros(3), []
    for _ in range(100_000):
        state = state + np.array([interval * state[1] + 0.5 * interval**2 * state[2], interval * state[2], 0.0])
        off = 1e-3 * random.standard_normal() - state[0] + latency * state[1]
        state = state + off * np.array([1.0 - kept**3, 1.5 * (1.0 - kept**2) * lost / interval, lost**3 / interval**2])
        speeds.append(state[1])
    assert np.std(speeds) == pytest.approx(velocity_noise(1e-3, latency, interval, 15.0), rel=0.1)


def finding(source: str, **sensors: float) -> Finding | None:
    keys = {f"simulation.{name.replace('__', '.')}": value for name, value in sensors.items()}
    found = {one.name: one for one in setup_findings(Model(Scenario.load(source, keys)))}
    return found.get("noise of poses")


@pytest.mark.parametrize(
    ("position", "latency", "severity"),
    [(0.001, 0.02, "ok"), (0.001, 0.04, "ok"), (0.002, 0.02, "error"), (0.002, 0.04, "error"), (0.0005, 0.05, "ok")],
)
def test_the_check_refuses_poses_too_noisy_to_push(position: float, latency: float, severity: str) -> None:
    keys = {"noise__position": position, "sensors__latency": latency, "sensors__rate": 100.0}
    found = finding("push", **keys)
    assert found is not None and found.severity == severity, found
    assert finding("paper", **keys) is None, "a grip loses no contact"


def test_the_checklist_refuses_what_the_check_refuses() -> None:
    model = Model(Scenario.load("push"))
    good, bad = (judge_noise(model, size, 0.04, 100.0) for size in (1e-3, 2e-3))
    assert (good.verdict, bad.verdict) == (Verdict.GOOD, Verdict.BAD) and "gripper" in bad.advice
    assert force_noise(model, 2e-3, 0.04, 0.01) > most_force_noise(model)
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
