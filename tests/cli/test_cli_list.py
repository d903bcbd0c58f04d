"""`doorman list`: every scenario that ships, in a sentence of its own."""

from __future__ import annotations

import json
import re

from command_line import run

from doorman.resources import scenario_directory, shipped


def test_every_scenario_is_in_the_list_and_says_what_it_is():
    words = json.loads(run("list", "--json").stdout)
    assert list(words) == list(shipped(scenario_directory(), ".toml"))
    assert len(set(words.values())) == len(words)
    for name, sentence in words.items():
        assert re.fullmatch(r"[A-Z].{20,}\.", sentence), name
        assert not re.search(r"\bsame task\b|SI units|`", sentence), f"{name} cannot stand alone"
    result = run("list")
    assert result.exit_code == 0
    assert all(re.search(rf"^{name} ", result.stdout, re.MULTILINE) for name in words)
