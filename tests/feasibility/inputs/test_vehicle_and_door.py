"""Warnings of what a URDF leaves open: rotors that are assumed, joints that stand."""

from __future__ import annotations

from pathlib import Path

from urdf_variants import DOOR, VEHICLE, write_edited

from doorman.feasibility.inputs.door import door_findings
from doorman.feasibility.inputs.setup import setup_findings
from doorman.feasibility.inputs.vehicle import vehicle_findings
from doorman.feasibility.report import Severity
from doorman.model import Model
from doorman.scenario import Scenario

JOINT = (
    '<link name="thing"/><joint name="free" type="revolute"><parent link="{}"/><child link="thing"/><axis xyz="0 0 1"/>'
    '<limit lower="0" upper="1" effort="1" velocity="1"/></joint></robot>'
)


def test_the_shipped_vehicle_and_door_leave_nothing_open():
    model = Model(Scenario.load("paper"))
    found = [*vehicle_findings(model), *door_findings(model)]
    assert all(finding.ok for finding in found)
    assert {finding.name for finding in found} <= {finding.name for finding in setup_findings(model)}


MOTORS = (
    VEHICLE.read_text(encoding="utf-8").replace('name="rotor_', 'name="motor_').replace('link="rotor_', 'link="motor_')
)
"""A vehicle whose rotors have another name."""


def test_rotors_that_nobody_named_are_an_error_with_what_is_there(tmp_path: Path):
    vehicle = tmp_path / "vehicle.urdf"
    vehicle.write_text(MOTORS, encoding="utf-8")
    findings = {}
    for assume in (False, True):
        scenario = Scenario.load("paper", {"vehicle.urdf": str(vehicle), "vehicle.rotors.assume": assume})
        findings[assume] = {one.name: one for one in vehicle_findings(Model(scenario))}["rotor frames"]
    assert (findings[False].severity, findings[True].severity) == (Severity.ERROR, Severity.WARNING)
    assert all(f"motor_{k}" in findings[False].message for k in range(1, 7)) and "servo" not in findings[False].message
    assert "vehicle.rotors.assume" in findings[False].advice


def test_what_is_left_open_is_a_warning_with_the_fix(tmp_path: Path):
    vehicle = tmp_path / "vehicle.urdf"
    vehicle.write_text(MOTORS.replace("</robot>", JOINT.format("servo_2")), encoding="utf-8")
    door = write_edited(tmp_path / "door.urdf", DOOR, ("</robot>", JOINT.format("frame")))
    values = {"vehicle.urdf": str(vehicle), "vehicle.rotors.assume": True, "door.urdf": str(door)}
    model = Model(Scenario.load("paper", values))
    found = {finding.name: finding for finding in [*vehicle_findings(model), *door_findings(model)]}
    assert found.pop("door as read").severity is Severity.OK
    assert {finding.severity for finding in found.values()} == {Severity.WARNING}
    rotors = found["rotor frames"]
    assert "6 upright ones are assumed, 0.28 m" in rotors.message and "rotor_1" in rotors.advice
    assert "free" in found["vehicle's joints"].message and "free" in found["door's joints"].message
    assert all(finding.advice for finding in found.values())


def test_propellers_beyond_the_disc_are_a_warning(tmp_path: Path):
    path = write_edited(tmp_path / "vehicle.urdf", VEHICLE, ('radius="0.40"', 'radius="0.30"'))
    (found,) = (
        one for one in vehicle_findings(Model(Scenario(vehicle={"urdf": str(path)}))) if one.name == "rotor disc"
    )
    assert found.severity is Severity.WARNING
    assert "0.300" in found.message and "0.394" in found.message and "base_link" in found.advice
