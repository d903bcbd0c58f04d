"""The check of a scenario: one list of findings, by which `check`, `open`, `fly` and `simulate` decide."""

from __future__ import annotations

from dataclasses import replace

from doorman.collision.audit import AuditReport, audit
from doorman.feasibility.inputs.plant import plant_finding
from doorman.feasibility.inputs.setup import setup_findings
from doorman.feasibility.mission import mission_findings
from doorman.feasibility.pressed import hold_findings, slip_findings
from doorman.feasibility.report import Finding, Report, Severity, found
from doorman.feasibility.swing.flight import flight_findings
from doorman.feasibility.swing.geometry import geometry_findings
from doorman.feasibility.swing.postures import postures_finding
from doorman.feasibility.swing.rehearsal import rehearse
from doorman.feasibility.task import task_finding
from doorman.feasibility.through import through_findings
from doorman.model import Model
from doorman.scenario import Scenario
from doorman.stages import stages


def check(scenario: Scenario | Model, *, with_audit: bool = False) -> Report:
    """Whether a scenario can work; takes less than a second, and the audit some seconds more.

    Masses, inertias and numbers are looked at, and what MuJoCo makes of the URDFs where it is installed.
    Geometry is looked at for level postures at every door angle of the swing (any yaw, the arm within its joint limits).
    What the planner makes of the task is rehearsed in closed loop with a model of the swing, without noise or tracking error.
    What would make the mission give up is looked for before the leaf and along that rehearsal.
    """
    model = scenario if isinstance(scenario, Model) else Model(scenario)
    if model.scenario.first:
        return _of_steps(model.scenario)
    rehearsal = rehearse(model)
    findings = (
        task_finding(model),
        *setup_findings(model),
        postures_finding(model),
        plant_finding(model),
        *geometry_findings(model),
        *slip_findings(model),
        *mission_findings(model, rehearsal),
        *flight_findings(model, rehearsal),
        *through_findings(model),
    )
    if not with_audit:
        return Report(model.scenario.name, findings)
    report = audit(
        model.coupling,
        model.constraints_along,
        door_angles=(model.start_angle, model.goal_angle),
        max_tilt=model.scenario.control.max_tilt,
    )
    return Report(model.scenario.name, (*findings, audit_finding(report)), report)


def _of_steps(scenario: Scenario) -> Report:
    """Findings of all steps; those before the last are named after their joints."""
    *before, last = steps = stages(scenario)
    findings = [
        replace(finding, name=f"{step.door.section.hinge}: {finding.name}")
        for step, following in zip(before, steps[1:], strict=True)
        for finding in (*check(step).findings, *hold_findings(step, following))
    ]
    return Report(scenario.name, (*findings, *check(last).findings))


def audit_finding(report: AuditReport) -> Finding:
    """Verdict of the audit; a warning where it fails, as it covers all postures and not only those of the swing."""
    advice = "use a wider doorway, a longer arm or a smaller disc (vehicle.radius)"
    if report.colliding:
        advice = "the constraints do not keep these shapes apart: watch 'clearance along the swing'"
    return found(
        "constraints against FCL", report.ok,
        f"{report.reason}; {1e2 * report.forbidden_free_share:.0f} % of all collision-free configurations are forbidden",
        float(report.colliding), 0.0, "configurations", advice, Severity.WARNING,
    )  # fmt: skip
