"""The page of results, from the raw figures of the workloads that have run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from suite import plots, tables, texts
from suite.peers import ENTRIES
from suite.standard import tables as standard
from suite.statistics import by, milliseconds, ratios

Results = dict[str, Any]


def page(results: Results) -> str:
    """Markdown of everything that has run."""
    sections: list[tuple[str, str, Callable[[Any], str]]] = [
        ("cold", "## Cold plans", lambda r: _with_plot(texts.COLD, "cold", tables.cold(r["rows"]))),
        ("limits", "## Cold plans with limits", lambda r: f"{texts.LIMITS}\n\n{tables.cold(r['rows'])}"),
        ("doors", "## Other doors", lambda r: _with_plot(texts.DOORS, "doors", tables.cold(r["rows"]))),
        ("replans", "## Replans", lambda r: _replans(texts.REPLANS, "replans", r)),
        ("disturbed", "## Replans under noise", lambda r: _replans(texts.DISTURBED, "disturbed", r)),
        ("perturbed", "## Perturbed starts", _perturbed),
        ("horizons", "## Longer horizons",
         lambda r: _with_plot(texts.SIZES, "horizons", tables.sizes(r["rows"], "horizon", "N"))),
        ("arms", "## Longer arms", lambda r: _with_plot(texts.SIZES, "arms", tables.sizes(r["rows"], "joints", "joints"))),
        ("phases", "## Where the time goes",
         lambda r: _with_plot(texts.PHASES, "phases", tables.phases(r["seconds"]))),
        ("push", "## Pushing",
         lambda r: f"{texts.PUSH}\n\n{tables.push(r['rows'], r['rows_of_a_node'])}\n{_meeting(r)}"),
        ("standard", "## Standard problems", standard.report),
        ("fresh", "## A fresh process", _fresh),
        ("closed_loop", "## Real time", _real_time),
        ("control_loop", "## Control loop", _control_loop),
    ]  # fmt: skip
    parts = [texts.INTRODUCTION, _at_a_glance(results)]
    parts += [f"{heading}\n\n{write(results[name])}" for name, heading, write in sections if name in results]
    if "floor" in results:
        parts.append(f"## Distance to the floor\n\n{_floor(results)}")
    parts += [
        f"## Solvers that are missing\n\n{tables.missing(results['missing'])}",
        _machine(results["machine"]),
    ]
    return "\n".join(parts)


def draw(results: Results, folder: Path) -> None:
    """Plots of everything that has run."""
    figures = {
        "cold": plots.cold, "doors": plots.doors, "replans": plots.replans, "disturbed": plots.disturbed,
        "horizons": plots.horizons, "arms": plots.arms,
    }  # fmt: skip
    for name, figure in figures.items():
        if name in results:
            plots.save(figure(results[name]["rows"]), folder, name)
    if "phases" in results:
        plots.save(plots.phases(results["phases"]["seconds"]), folder, "phases")


def _with_plot(text: str, name: str, table: str) -> str:
    return f"{text}\n\n{table}\n![{name}](benchmarks/{name}.png)\n"


def _at_a_glance(results: Results) -> str:
    lines = []
    if "cold" in results:
        for solver, median_goal, least_goal in (
            ("fatrop", "15", "10"),
            ("hpipm_tuned", "", ""),
            ("acados_door", "", ""),
        ):
            ratio = ratios(results["cold"]["rows"], solver, ("task", "state"))
            if len(ratio):
                figure = f"cold plan, times faster than {ENTRIES[solver].label}"
                lines.append([f"{figure}: median", tables.number(np.median(ratio)), median_goal])
                lines.append([f"{figure}: least", tables.number(ratio.min()), least_goal])
    for name, goals in (("replans", ("3", "1e-5", "1e-6")), ("disturbed", ("", "1e-3", "1e-6"))):
        if name in results:
            lines += _replan_lines(results[name], name, goals)
    lines += [
        [f"push, replan, noise {noise}: times faster than acados", tables.number(ratio), "8" if noise == "none" else ""]
        for noise, ratio in tables.against_acados(results.get("push", {}).get("replans", ())).items()
    ]
    for row in results.get("control_loop", {}).get("rows", ()):
        if "error" not in row:
            times = [tables.number(1e3 * row["solve"][key]) for key in ("median", "max")]
            lines.append([f"plan in flight, `{row['scenario']}`, ms: median / max", " / ".join(times), ""])
    return "## At a glance\n\n" + tables.markdown(["figure", "measured", "goal"], lines) if lines else ""


def _replan_lines(result: Any, name: str, goals: tuple[str, str, str]) -> list[list[str]]:
    good = [row for row in result["rows"] if "seconds" in row]
    steady = _steady(good)
    ours, lines = [row for row in good if row["solver"] == "doorman"], []
    prefix = "replan" if name == "replans" else "replan under noise"
    if name == "replans":
        for solver, goal in (("hpipm_tuned", "25"), ("hpipm", "25"), ("acados_door", "12")):
            if len(steady.get(solver, ())):
                ratio = float(np.median(steady[solver]) / np.median(steady["doorman"]))
                figure = f"replan, times faster than one iteration of {ENTRIES[solver].label}"
                lines.append([figure, tables.number(ratio), goal])
    times = [f(steady["doorman"]) for f in (np.median, lambda all_: np.percentile(all_, 99), np.max)]
    lines.append([f"{prefix}, ms: median / p99 / max", " / ".join(map(tables.number, times)), ""])
    cold_caches = _steady(result.get("cold_caches", ()))
    cold, rival = (cold_caches.get(solver, ()) for solver in ("doorman", "acados_door"))
    if len(cold) and len(rival):
        ratio = float(np.median(rival) / np.median(cold))
        lines.append([f"{prefix}, caches cold, times faster than acados", tables.number(ratio), "8"])
    if len(cold):
        lines.append(
            [
                f"{prefix}, caches cold, ms: median / max",
                f"{tables.number(np.median(cold))} / {tables.number(np.max(cold))}",
                "",
            ]
        )
    if goals[0]:
        lines.append([f"{prefix}, p99 over median", tables.number(times[1] / times[0]), goals[0]])
    gap = max(abs(row["gap"]) for row in ours)
    violation = max(row["violation"] for row in ours if row["usable"])
    lines.append([f"{prefix}, worst suboptimality", tables.number(gap), goals[1]])
    lines.append([f"{prefix}, worst violation of a usable plan", tables.number(violation), goals[2]])
    return lines


def _steady(rows: Any) -> dict[str, Any]:
    """Times of calls that the scheduler did not interrupt, by solver [ms]."""
    calm = [row for row in rows if "seconds" in row and not row["interrupted"]]
    return {solver: milliseconds(own) for solver, own in by(calm, "solver").items()}


def _replans(text: str, name: str, result: Any) -> str:
    errors = {row["solver"]: row["error"] for row in result["rows"] if "error" in row}
    said = "".join(f"\n{solver} fell out: {error}\n" for solver, error in errors.items())
    times = tables.replan_times(result["rows"], result.get("cold_caches", ()))
    return _with_plot(text, name, f"{times}{said}\n{tables.replan_quality(result['rows'])}")


def _perturbed(result: Any) -> str:
    return (
        f"{texts.PERTURBED}\n\n{tables.perturbed(result['rows'])}\nPlans of doorman from starts that violate the constraints:\n\n"
        f"{tables.recovery(result['rows'])}"
    )


def _fresh(result: Any) -> str:
    rows = result["rows"]
    worst = {
        key: max(row[key] for row in rows)
        for key in ("import", "planner", "first_plan", "total", "on_core", "peak_memory")
    }
    heading = [
        "import, s",
        "making the planner, s",
        "first plan, s",
        "in all, s",
        "of that on the core, s",
        "peak memory, MB",
    ]
    line = [tables.number(worst[key]) for key in ("import", "planner", "first_plan", "total", "on_core")]
    return f"{texts.FRESH}\n\n{tables.markdown(heading, [[*line, tables.number(worst['peak_memory'] / 1e6)]])}"


def _meeting(result: Any) -> str:
    """What happens where doorman and acados meet at the same states of a push."""
    if "replans" not in result:  # measured before there was an acados to meet
        return ""
    return f"{texts.MEETING}\n\n{tables.meeting_cold(result['cold'])}\n{tables.meeting_replans(result['replans'])}"


def _real_time(result: Any) -> str:
    heading = ["plans", "missed deadlines", "missed though fast", "not usable", "ms, median", "p99", "p99.9", "max"]
    durations = [tables.number(1e3 * result["durations"][key]) for key in ("median", "p99", "p99.9", "max")]
    line = [str(result[key]) for key in ("plans", "missed", "missed_though_fast", "unusable")] + durations
    priority = "with" if result["real_time_priority"] else "without"
    text = f"{texts.REAL_TIME} The planner ran {priority} real-time priority."
    return f"{text}\n\n{tables.markdown(heading, [line])}\n{_nothing(result)}"


def _control_loop(result: Any) -> str:
    heading = ["scenario", "ticks", "missed", "ms off the period, median", "p99", "p99.9", "max", "plans", "ms between",
               "ms a plan, median", "max"]  # fmt: skip
    lines = []
    for row in result["rows"]:
        if "error" in row:
            lines.append([row["scenario"], row["error"], *[""] * (len(heading) - 2)])
            continue
        off = [tables.number(1e3 * row["off"][key]) for key in ("median", "p99", "p99.9", "max")]
        plans = [tables.number(1e3 * value) for value in (row["planning"], row["solve"]["median"], row["solve"]["max"])]
        lines.append([row["scenario"], str(row["ticks"]), str(row["missed"]), *off, str(row["plans"]), *plans])
    priority = "with" if all(row.get("priority") for row in result["rows"]) else "without"
    text = f"{texts.CONTROL_LOOP} It ran {priority} real-time priority."
    return f"{text}\n\n{tables.markdown(heading, lines)}\n{_nothing(result)}"


def _nothing(result: Any) -> str:
    """What a loop without any work missed."""
    nothing = result.get("nothing")
    if nothing is None:  # measured before there was one
        return ""
    off = [tables.number(1e3 * nothing["off"][key]) for key in ("median", "p99", "p99.9", "max")]
    heading = ["ticks", "missed", "ms off the period, median", "p99", "p99.9", "max"]
    return f"{texts.NOTHING}\n\n{tables.markdown(heading, [[str(nothing['ticks']), str(nothing['missed']), *off]])}"


def _floor(results: Results) -> str:
    floor = results["floor"]
    floor_time = floor["flop"] / floor["peak_flop_per_second"]
    lines = [[name, f"{flop / 1e3:.0f}"] for name, flop in floor["flop_by_part"].items()]
    lines.append(["in all", f"{floor['flop'] / 1e3:.0f}"])
    text = f"{texts.FLOOR}\n\n{tables.markdown(['part', 'thousand operations'], lines)}\n"
    text += f"At {floor['peak_flop_per_second'] / 1e9:.0f} Gflop/s that is {1e6 * floor_time:.1f} µs"
    if "replans" in results:
        rows = [row for row in results["replans"]["rows"] if row["solver"] == "doorman" and not row["interrupted"]]
        median = float(np.median(milliseconds(rows)))
        text += (
            f"; doorman's median replan takes {1e3 * median:.0f} µs, {1e-3 * median / floor_time:.1f} times the floor"
        )
    return text + ".\n"


def _machine(machine: Any) -> str:
    ours = ", ".join(f"{name} {version}" for name, version in machine["versions"].items())
    peers = ", ".join(f"{name} {version}" for name, version in machine["peer_versions"].items())
    lines = [
        ["measured", machine["when"]],
        ["run", "quick: fewer states and repetitions" if machine["quick"] else "full"],
        ["processor", f"{machine['processor']}; {machine['cores']} cores, solvers on core {machine['core']}"],
        ["memory", f"{machine['memory'] / 2**30:.0f} GiB"],
        ["load average at the start", f"{machine['load']:.2f}"],
        ["system", machine["system"]],
        ["Python", machine["python"]],
        ["C compiler of the generated code", machine["compiler"]],
        ["doorman's environment", ours],
        ["the peers' environment", peers],
        ["built from sources", ", ".join(f"{name} {version}" for name, version in machine.get("built", {}).items())],
    ]
    return f"## Machine\n\n{tables.markdown(['what', 'value'], lines)}"
