"""Rows on disk: durable one by one, whole or not there, with columns that not every row has."""

from __future__ import annotations

import math

import pyarrow.parquet as parquet

from doorman.campaign.results import read_parts, row_of, write_part, write_table

SUMMARY = {
    "final_door_angle_deg": 21.0, "target_door_angle_deg": 20.0, "final_error": 1.0, "unit": "deg",
    "collisions": 0, "opened": True, "time_to_open_s": None,
    "planner_ms": {"median": 1.0, "p99": 2.0, "max": 3.0}, "phases": ["hover", "open"], "outcome": "completed",
    "reason": "", "estimates": {"torque": {"value": 1.2, "true": 1.5, "deviation": 0.1}},
}  # fmt: skip


def answer(**change: object) -> dict:
    return {"summary": SUMMARY, "error": None, "wall_time_s": 1.5, "kernels_compiled": 0} | change


def test_a_row_has_the_draws_the_judgement_and_the_flat_summary(campaign):
    flight = campaign.flights(1)[0]
    row = row_of(flight, answer())
    assert (row["run"], row["seed"], row["success"], row["reason"]) == (0, flight.draw.seed, True, "")
    assert row["final_error_deg"] == 1.0 and row["outcome"] == "completed" and row["safe"] is True
    assert row["torque_error_n_m"] == 1.2 - 1.5
    assert row["drawn.simulation.door_mass"] == flight.draw.values["simulation.door_mass"]
    assert row["friction"] == flight.draw.values["simulation.door_friction"]
    assert row["summary.planner_ms.p99"] == 2.0 and row["summary.phases"] == '["hover", "open"]'
    failed = row_of(flight, answer(summary=None, error="BackendError: it broke"))
    assert (failed["success"], failed["outcome"], failed["reason"]) == (False, "error", "BackendError: it broke")
    assert failed["safe"] is False
    assert not any(name.startswith("summary.") for name in failed)


def test_parts_come_back_as_they_were(campaign, tmp_path):
    flights = campaign.flights(3)
    written = [
        row_of(flight, answer(**change)) for flight, change in zip(flights, ({}, {"summary": None}, {}), strict=True)
    ]
    for row in written:
        write_part(row, tmp_path)
    whole = next(tmp_path.glob("*.parquet")).read_bytes()
    (tmp_path / "run-0000003.unfinished").write_bytes(whole[: len(whole) // 2])
    assert list(read_parts(tmp_path).values()) == written


def test_rows_of_different_columns_and_types_make_one_table(tmp_path):
    rows = [
        {"run": 0, "a": 1, "b": "x", "d": 1},
        {"run": 1, "a": 2.5, "c": True, "d": "text"},
        {"run": 2, "a": math.inf},
    ]
    write_table(rows, tmp_path / "all.parquet")
    table = parquet.read_table(tmp_path / "all.parquet").to_pylist()
    assert [row["a"] for row in table] == [1.0, 2.5, math.inf]
    assert table[0]["b"] == "x" and table[0]["c"] is None and table[1]["c"] is True
    assert [row["d"] for row in table] == ["1", '"text"', None]
