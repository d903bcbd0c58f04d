"""Ask whether a door can be opened, and what to change if not: the shipped one, with a heavier and stiffer hinge."""

from doorman import Scenario
from doorman.feasibility import check

for friction in (0.0, 1.0, 10.0):
    scenario = Scenario.load("paper", overrides={"door.friction": friction, "door.mass": 15.0})
    report = check(scenario)
    print(f"friction {friction:4.1f} N m: {'possible' if report.possible else 'not possible'}")
    for finding in report.findings:
        if finding.severity != "ok":
            print(f"    {finding.severity}: {finding.message}")
