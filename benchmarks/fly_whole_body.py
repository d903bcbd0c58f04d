"""Fly draws of a campaign with the whole-body plan at the leaf, and print a line a flight and the sum.

Usage: python benchmarks/fly_whole_body.py [push_campaign] [--first 20] [--begin 0] [--push] [--set KEY=VALUE]

With --push today's push flies the same draws: the numbers can be compared.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))

from suite.whole_body.flight import fly  # noqa: E402

from doorman.campaign.draws import draw  # noqa: E402
from doorman.campaign.judgement import judge  # noqa: E402
from doorman.cli.overrides import parse_overrides  # noqa: E402
from doorman.mission.simulate import simulate  # noqa: E402
from doorman.model import Model  # noqa: E402
from doorman.scenario import Scenario  # noqa: E402


def main() -> None:
    arguments = parse()
    base = Scenario.load(arguments.scenario, parse_overrides(arguments.set))
    found = []
    for run in range(arguments.begin, arguments.begin + arguments.first):
        drawn = draw(base.campaign, run)
        model = Model(base.replace(drawn.values))
        if arguments.push:
            recording = simulate(model, seed=drawn.seed, force=True)
            summary: dict[str, Any] = dict(recording.summary or {})
        else:
            summary = fly(model, drawn.seed)
        summary["success"] = judge(summary).success
        found.append(summary)
        print(line(run, summary), flush=True)
    print(total(found))


def line(run: int, summary: dict[str, Any]) -> str:
    """One flight."""
    words = "opened" if summary["success"] else f"not opened: {summary['reason'] or summary['outcome']}"
    return (
        f"{run:3d} {words}; {summary['final_door_angle_deg']:.1f}°, contact {summary['contact_fraction']:.3f}, peak "
        f"{summary['max_push_force_n']:.1f} N, touched {summary['collisions']}, "
        f"opened in {summary['time_to_open_s'] or 0.0:.1f} s, "
        f"plans {', '.join(f'{value:.2f}' for value in summary.get('whole_body_ms', []))} ms"
    )


def total(found: list[dict[str, Any]]) -> str:
    """All flights."""
    contact = [each["contact_fraction"] for each in found]
    peaks = [each["max_push_force_n"] for each in found]
    return (
        f"opened {sum(each['success'] for each in found)} of {len(found)}, "
        f"touched {sum(each['collisions'] > 0 for each in found)}, "
        f"contact {np.median(contact):.3f} (least {min(contact):.3f}), peak {np.median(peaks):.1f} N (most {max(peaks):.1f} N)"
    )


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", default="push_campaign", help="with draws: name or path")
    parser.add_argument("--first", type=int, default=20, help="so many draws")
    parser.add_argument("--begin", type=int, default=0, help="from this one on")
    parser.add_argument("--push", action="store_true", help="today's push instead")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="override of all flights")
    return parser.parse_args()


if __name__ == "__main__":
    main()
