"""The mission on the vehicle, from checklist to landing, as `doorman fly` and `doorman rig --fly` fly it."""

from __future__ import annotations

import json
import math
import signal
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import typer
from rich.console import Console
from rich.text import Text

from doorman import __version__
from doorman.cli.listeners import fed
from doorman.cli.run_folder import new_folder
from doorman.cli.terminal.background_printer import BackgroundPrinter
from doorman.cli.terminal.display import COLORS, print_table, with_advice
from doorman.cli.values import parse_overrides
from doorman.cli.vehicles.door import door_source
from doorman.dynamics.attitude_loop import AttitudeLoop
from doorman.exceptions import DoormanError, RecordingError
from doorman.feasibility import check
from doorman.flight import Check, End, FlightReport, FlightSession, Verdict, listen, preflight, ready, rehearse
from doorman.flight.ground.listening import NEEDED, without_links
from doorman.flight.guarded import STOPPING
from doorman.flown import carried_files, recorded_header, recorded_loop
from doorman.hardware.scheduling import real_time
from doorman.hardware.vehicle import VehicleConfig, VehicleLinks
from doorman.hardware.vehicle.waiting import await_links
from doorman.hardware.vehicle_file import VehicleFile
from doorman.model import Model
from doorman.planning.planner import Planner
from doorman.recording import Recorder, Recording
from doorman.summary import has_measured_leaf, sentence_by_the_leaf, summarize

_COLORS = dict(zip((Verdict.GOOD, Verdict.WARNING, Verdict.BAD), COLORS, strict=True))

Output = Literal["words", "json", "quiet"]
"""What goes to stdout."""


def fly_mission(
    source: str,
    settings: Sequence[str] | None,
    vehicle: str | None,
    links: Mapping[str, object],
    out: Path | None,
    duration: float | None,
    dry_run: bool,
    yes: bool,
    output: Output = "words",
    feed: int | None = None,
) -> int:
    """Go through the checklist, ask, fly, and say how it ended."""
    if duration is not None and not 0.0 < duration < math.inf:
        raise DoormanError("not a duration", field="--duration", given=duration, allowed="a number of seconds > 0")
    file = VehicleFile() if vehicle is None else VehicleFile.load(vehicle)
    model = Model(file.scenario(source, parse_overrides(settings)))
    mission = Mission(model, out, duration, yes, feed, output != "words")
    if dry_run:
        checks = _dry_run(model, file, links, vehicle is None)
        mission.show(checks)
        good = ready(checks)
        words = "no check failed so far" if good else "the vehicle would not fly, see the lines marked 'no'"
        result = mission.grounded(good, f"Dry run: {words}. Nothing was sent.")
    else:
        checks, result = mission.on_the_vehicle(file.links(model, links))
        good = result["completed"] and result["end"] == End.LANDED.value and not result["seen"]
    if output == "json":
        typer.echo(json.dumps({"checklist": _as_data(checks), **result}, indent=2))
    return 0 if good else 1


def _dry_run(model: Model, file: VehicleFile, links: Mapping[str, object], no_file: bool) -> list[Check]:
    """Check what can be checked without sending anything."""
    if no_file and not links.keys() >= NEEDED.keys():
        return without_links(model, check(model), links)
    config, findings = file.links(model, links), check(model)
    Console(stderr=True).print("Listening to the links without sending")
    return listen(model, config, findings)


def _as_data(checks: list[Check]) -> list[dict[str, str]]:
    return [{**vars(one), "verdict": one.verdict.value} for one in checks]


@dataclass(frozen=True)
class Mission:
    """A mission and its operator, who is asked before it."""

    model: Model
    out: Path | None = None
    duration: float | None = None
    yes: bool = False  # do not ask
    feed: int | None = None
    aside: bool = False  # words go to stderr: stdout is for programs

    def say(self, words: str) -> None:
        typer.echo(words, err=self.aside)

    def show(self, checks: list[Check]) -> None:
        rows = (
            (Text(one.verdict.value, _COLORS[one.verdict]), one.name, with_advice(one.found, one.advice))
            for one in checks
        )
        print_table(("", "checked", "found"), rows, err=self.aside)

    def on_the_vehicle(self, config: VehicleConfig) -> tuple[list[Check], dict[str, Any]]:
        """Checklist and result of a flight, or of one that stays on the ground."""
        tell = Console(stderr=True, highlight=False).print
        tell("Preparing planner and controller")
        planner, findings = Planner(self.model), check(self.model)
        rehearse(self.model, planner)
        tell("Opening the links")
        with real_time(), VehicleLinks(config, door=door_source(config)) as links:
            await_links(links, tell)
            checks = preflight(self.model, links, findings)
            self.show(checks)
            result = self.written(links) or self._refusal(checks)
            if result is None and not self.yes:  # the answer may have taken its time
                checks = preflight(self.model, links, findings)
                if not ready(checks):
                    self.show(checks)
                    result = self._refusal(checks)
            if result is None:
                result = self._fly(links, planner, checks)
        return checks, result

    def grounded(self, good: bool, words: str) -> dict[str, Any]:
        """Result of a flight that stays on the ground, after a word why."""
        self.say(words)
        return {"ready": good, "completed": False, "message": words}

    def written(self, links: VehicleLinks) -> dict[str, Any] | None:
        """Result of a flight that may write parameters and has found wrong ones; None if there are none."""
        autopilot = links.autopilot
        if not autopilot.config.write_parameters or autopilot.state().armed or not autopilot.check_parameters():
            return None
        written = autopilot.fix_parameters()
        left = autopilot.check_parameters()
        by_hand = f"To be set by hand: {'; '.join(map(str, left))}." if left else ""
        done = f"Written and read back: {', '.join(written)}. Reboot the autopilot, then fly."
        words = f"{done if written else 'No parameter could be written.'} {by_hand}".strip()
        return self.grounded(False, words) | {"written": list(written)}

    def _refusal(self, checks: list[Check]) -> dict[str, Any] | None:
        """Result of a flight that stays on the ground, and why; None if it is to be flown."""
        if not ready(checks):
            return self.grounded(False, "The vehicle does not fly: see the lines marked 'no'.")
        return None if self.yes or self.confirmed() else self.grounded(True, "Not flown.")

    def confirmed(self) -> bool:
        """Whether the operator wants to fly; no answer is a no."""
        try:
            return typer.confirm("Arm and fly?", default=False, err=self.aside)
        except typer.Abort:
            return False

    def _fly(self, links: VehicleLinks, planner: Planner, checks: list[Check]) -> dict[str, Any]:
        path, scenario = self.out or new_folder(f"fly-{self.model.scenario.name}") / "flight.mcap", self.model.scenario
        flown = {"version": __version__, "links": asdict(links.config), "checklist": _as_data(checks)}
        header, unwritten = recorded_header(scenario) | flown, ""
        with BackgroundPrinter(sys.stderr) as printer, fed(self.feed) as listener:
            recorder = Recorder(path, header, listener, keep=False, attachments=carried_files(scenario))
            try:
                session = FlightSession(
                    self.model, links, planner, recorder, say=lambda words: printer.print(f"· {words}")
                )
                with _ctrl_c(session):
                    report = session.fly(self.duration, _StatusLine(session, printer))
                gap = links.autopilot.status().longest_setpoint_gap
                timing = {**vars(session.backend.ticks), "longest_setpoint_gap": gap}
                recorder.write("timing", 0.0, timing)
            finally:
                try:
                    recorder.close()
                except (
                    RecordingError
                ) as error:  # the disk is full: the flight has ended as it would have, and is reported
                    unwritten = str(error)
                    printer.print(f"The recording is not whole: {unwritten}")
        loop, judged = (None, None) if unwritten else _measured(path, self.model)
        for words in _how_it_ended(report, session, gap, path, loop):
            self.say(words)
        if judged is not None:
            self.say(sentence_by_the_leaf(judged))
        return {
            "ready": True, "completed": report.completed, "message": report.message, "end": report.end.value,
            "seen": report.seen, "recording": str(path), "unwritten": unwritten, "by_the_leaf": judged, "timing": timing,
            "attitude_lag_s": loop and loop.lag, "attitude_dead_time_s": loop and loop.dead_time,
            "hover": {name: value for name, value in session.flight.measured.items() if math.isfinite(value)},
            "journal": session.journal.lines,
        }  # fmt: skip


def _measured(path: Path, model: Model) -> tuple[AttitudeLoop | None, dict[str, Any] | None]:
    """Attitude loop of a recorded flight, and its figures by the measured leaf; None for what it did not measure."""
    loop, judged = None, None
    with suppress(DoormanError):
        recording = Recording.load(path)
        loop = recorded_loop(recording)
        judged = summarize(recording, model) if has_measured_leaf(recording) else None
    return loop, judged


class _StatusLine:
    """Prints where the flight is, now and then; called by the mission."""

    def __init__(self, session: FlightSession, printer: BackgroundPrinter) -> None:
        self._session, self._printer, self._next = session, printer, 0.0

    def __call__(self, now: float, door_angle: float) -> None:
        if now < self._next:
            return
        self._next = now + 0.5
        state = self._session.links.autopilot.state()
        x, y, z = state.position
        words = (
            f"{now:5.1f} s  {self._session.phase:9s} door {math.degrees(door_angle):5.1f}°  at {x:.2f}, {y:.2f}, {z:.2f} m"
            f"  {state.mode}  {state.battery.voltage:.1f} V  missed {self._session.backend.missed_ticks}"
        )
        self._printer.print_over(words)


@contextmanager
def _ctrl_c(session: FlightSession) -> Iterator[None]:
    """Ctrl-C, SIGTERM, SIGQUIT and SIGHUP, of a terminal that is gone, go to the session; the handlers before are put back."""
    # What would stop the program, as Ctrl-Z does, is ignored: the vehicle would hear nothing any more.
    asks = {signal.SIGINT: session.interrupt, signal.SIGTERM: session.terminate, signal.SIGQUIT: session.terminate}
    if signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # nohup
        asks[signal.SIGHUP] = session.terminate
    handlers: dict[signal.Signals, Any] = {number: lambda *_, ask=ask: ask() for number, ask in asks.items()}
    handlers |= dict.fromkeys(STOPPING, signal.SIG_IGN)
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _how_it_ended(
    report: FlightReport, session: FlightSession, gap: float, path: Path, loop: AttitudeLoop | None
) -> Iterator[str]:
    ticks = session.backend.ticks
    done = "The mission was flown to its end" if report.completed else "The mission was not flown to its end"
    why = "" if not report.message else f": {report.message}"
    yield f"{done}{why}. The vehicle: {report.end.value}."
    if report.seen:
        yield f"Seen: {report.seen}."
    yield from (f"  {line}" for line in session.journal.lines[-15:])
    yield (
        f"Ticks: {ticks.ticks}, {ticks.missed} missed, p99.9 {ticks.p99_9 * 1e3:.1f} ms off; "
        f"longest gap of setpoints {gap * 1e3:.0f} ms. Recording: {path}"
    )
    if loop is not None:
        yield (
            f"The attitude begins to follow its setpoints after {loop.dead_time * 1e3:.0f} ms, and lags {loop.lag * 1e3:.0f} ms "
            "(doorman vehicle learn writes both)."
        )
