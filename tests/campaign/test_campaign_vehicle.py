"""A campaign flown by the vehicle of a vehicle file."""

from __future__ import annotations

import itertools
import shlex
import shutil
from pathlib import Path

import pyarrow.parquet
from command_line import run

from doorman.cli.task import load_task
from doorman.resources import urdf_directory


def test_a_campaign_flies_the_file_s_vehicle(tmp_path: Path, task: Path) -> None:
    shutil.copy(urdf_directory() / "hexarotor_arm.urdf", tmp_path / "mine.urdf")
    path = tmp_path / "my.toml"
    path.write_text('[vehicle]\nurdf = "mine.urdf"\n[control]\nmax_tilt = 0.21\n')
    out = tmp_path / "out"
    arguments = ["--vehicle", str(path), "--set", "control.max_tilt=0.3", "--runs", "1", "--workers", "1"]
    result = run("campaign", str(task), *arguments, "--out", str(out), "--json")
    assert result.exit_code == 0, result.output
    (row,) = pyarrow.parquet.read_table(out / "results.parquet").to_pylist()
    words = shlex.split(row["command"])
    assert words[words.index("--vehicle") + 1] == str(path)
    settings = [word for before, word in itertools.pairwise(words) if before == "--set"]
    again = load_task(words[2], settings, str(path))
    assert again.vehicle_urdf == (tmp_path / "mine.urdf").resolve()
    assert again.control.max_tilt == 0.3, "the command line wins"
