"""The check of a scenario: setup, geometry along the swing, a rehearsal, and the audit of the constraints."""

from __future__ import annotations

from doorman.collision.audit import AuditReport, audit
from doorman.feasibility.flight import flight_findings, stopping_findings
from doorman.feasibility.geometry import geometry_findings
from doorman.feasibility.postures import postures_finding
from doorman.feasibility.rehearsal import DURATION, rehearse
from doorman.feasibility.report import Finding, Report, Severity, graded
from doorman.feasibility.setup import setup_findings
from doorman.model import Model
from doorman.scenario import Scenario


def check(scenario: Scenario) -> Report:
    """Whether a scenario can work; takes a few seconds.

    Geometry is looked at for level postures at every door angle of the swing (any yaw, the arm within its joint limits).
    What the planner makes of the task is rehearsed in closed loop with a model of the swing, without noise or tracking error.
    The analytic constraints are audited against FCL up to the controller's largest tilt.

    Args:
        scenario: The scenario.

    Returns:
        The findings.

    Raises:
        UrdfError: if a URDF is unusable.
        ScenarioError: if the scenario does not fit its URDFs.
    """
    model = Model(scenario)
    report = audit(
        model.coupling,
        model.constraints_along,
        model.constraint_names,
        door_angles=(float(model.start_state[3]), float(model.goal_state[3])),
        max_tilt=scenario.control.max_tilt,
    )
    findings = (
        *setup_findings(model),
        postures_finding(model),
        *geometry_findings(model, DURATION),
        *flight_findings(model, rehearse(model)),
        audit_finding(report),
    )
    return Report(scenario.name, findings, report)


def beforehand(model: Model) -> tuple[Finding, ...]:
    """What `check` finds without a rehearsal, within a millisecond.

    Args:
        model: Model of the scenario.

    Returns:
        The findings.
    """
    return (*setup_findings(model), postures_finding(model), *stopping_findings(model))


def audit_finding(report: AuditReport) -> Finding:
    """Verdict of the audit; a warning where it fails, as it covers all postures and not only those of the swing.

    Args:
        report: Of the audit.

    Returns:
        The finding.
    """
    advice = ""
    if report.colliding:
        advice = "the constraints do not keep these shapes apart: watch 'clearance along the swing'"
    elif not report.ok:
        advice = "a wider doorway, a longer arm or a smaller disc (vehicle.radius)"
    return Finding(
        "constraints against FCL", graded(report.ok, Severity.WARNING),
        f"{report.reason}; {1e2 * report.forbidden_free_share:.0f} % of all collision-free configurations are forbidden",
        float(report.colliding), 0.0, "configurations", advice,
    )  # fmt: skip
