"""The attitude loop is measured in hover, before contact: small steps of roll, then of pitch."""

from __future__ import annotations

import math

import numpy as np

from doorman.arrays import Array
from doorman.control.estimation.loop_fit import LoopFit, MeasuredLoop, lateness
from doorman.dynamics.attitude_loop import TESTED_DEAD_TIME, TESTED_LAG
from doorman.model import Model
from doorman.signals import Measurement

_STEP = 0.03
"""Size of a step, 1.7°: the vehicle moves by 1 cm [rad]."""
_HALF = 0.2
"""Time of the first and the last step, half of the others': the vehicle stands where it stood before [s]."""
_QUIET = 0.25
"""Before the first step and after the last: the loop answers late [s]."""
_AXIS = 8.0 * _HALF
DURATION = 2.0 * (_QUIET + _AXIS)
"""Duration of the test [s]."""
_EXPLAINED = 0.5
"""Share of the motion that a fit explains at least, to count: wind moves the vehicle, too."""
_ALIKE = 0.05
"""By which lag and dead time together may differ between roll and pitch, to count: gusts and gaps in the poses spoil fits [s]."""


class LoopTest:
    """Steps to command, and what comes of them."""

    def __init__(self, model: Model) -> None:
        self._fit = LoopFit(DURATION, model.scenario.simulation.controller_rate)
        self._rates: list[tuple[float, Array]] = []
        self._attitudes: list[tuple[float, Array]] = []
        self.rates_late = 0.0
        """How much later than the poses' attitudes the body rates come, where that was measured [s]."""
        self._began: float | None = None
        self.done = "attitude" not in model.scenario.mission.measures
        """Whether nothing is left to test."""
        self.measured: MeasuredLoop | None = None
        """What came of it, where that explains the motion."""

    @property
    def runs(self) -> bool:
        """Whether steps are commanded now."""
        return self._began is not None and not self.done

    def step(self, now: float) -> Array:
        """Roll and pitch to add to the command, shape (2,) [rad]; the first call begins the test."""
        if self._began is None:
            self._began = now
        return self._steps(now - self._began)

    def _steps(self, time: float) -> Array:
        tilt = np.zeros(2)
        axis, within = divmod(time - _QUIET, _AXIS)
        if axis in (0.0, 1.0):
            tilt[int(axis)] = _STEP if math.floor(within / _HALF + 1.0) % 4 < 2 else -_STEP
        return tilt

    def note(self, commanded: Array, seen: Array, measured: Measurement) -> None:
        """Take in a tick of the test: what is commanded from now on, and the attitude by now."""
        assert self._began is not None
        now = measured.time
        self._fit.note(now, commanded[:2], seen[:2], measured.pose_time)
        self._rates.append((now, measured.body_rates[:2]))
        if not self._attitudes or self._attitudes[-1][0] < measured.pose_time:
            self._attitudes.append((measured.pose_time, measured.attitude[:2]))
        if now - self._began < DURATION:
            return
        self.done = True
        found = self._fit.fitted()
        if found is None or not (found.explained > _EXPLAINED).all():
            return
        late = found.lag + found.dead_time
        if abs(float(late[0] - late[1])) < _ALIKE + 0.2 * float(late.mean()):
            self.measured = found
            poses, rates = (
                [np.array(part) for part in zip(*taken, strict=True)] for taken in (self._attitudes, self._rates)
            )
            self.rates_late = lateness(*poses, *rates)

    def unfit(self) -> str:
        """Why contact does not bear this loop; empty if it does, or if it could not be measured."""
        if self.measured is None:
            return ""
        most = TESTED_LAG + TESTED_DEAD_TIME
        for axis, name in enumerate(("roll", "pitch")):
            lag, dead = float(self.measured.lag[axis]), float(self.measured.dead_time[axis])
            doubt = 2.0 * math.hypot(self.measured.lag_deviation[axis], self.measured.dead_time_deviation[axis])
            # a loop of another shape passes for one of less lag and more dead time
            if max(lag - TESTED_LAG, lag + dead - most) > doubt:
                px4, ardupilot = name.upper(), _SHORT[name]
                gains = f"raise MC_{px4}_P, MC_{px4}RATE_K (PX4), or ATC_ANG_{ardupilot}_P, ATC_RAT_{ardupilot}_P (ArduPilot)"
                line = (
                    "shorten the line to the autopilot, or raise IMU_GYRO_CUTOFF (PX4), or INS_GYRO_FILTER (ArduPilot)"
                )
                return (
                    f"{name} follows {1e3 * (lag + dead):.0f} ms behind its commands, {1e3 * dead:.0f} ms of it dead time; "
                    f"tested up to {1e3 * most:.0f} ms, and {1e3 * TESTED_LAG:.0f} ms of lag: "
                    f"{gains if lag > TESTED_LAG or dead < TESTED_DEAD_TIME else line}"
                )
        return ""


_SHORT = {"roll": "RLL", "pitch": "PIT"}
"""Axes in ArduPilot's parameters."""
