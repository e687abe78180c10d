"""What the documentation says on reading results with other tools is what they do."""

import re
from pathlib import Path

import pytest

DOCUMENT = Path(__file__).parents[2] / "docs" / "sweeps.md"


@pytest.mark.parametrize("tool", ["pandas", "polars", "duckdb"])
def test_each_tool_reads_solutions_in_the_documented_line(reproduced, monkeypatch, tool):
    pytest.importorskip(tool)
    lines = re.findall(rf"^import {tool}.*\n(?:.*\n)*?```", DOCUMENT.read_text(), re.MULTILINE)
    (block,) = lines
    monkeypatch.chdir(reproduced.parents[1])
    names = {}
    exec(block.removesuffix("```"), names)
    solutions = names["solutions"]
    assert len(solutions) > 10
    best = [row for row in rows(solutions, tool) if row["is_v_optimum"] and row["objective"] == "force"]
    assert [round(row["x_m"], 2) for row in best] == [1.82]


def rows(frame, tool):
    return frame.to_dicts() if tool == "polars" else frame.to_dict("records")


def test_units_are_read_as_documented(reproduced, monkeypatch):
    (block,) = re.findall(r"^import pyarrow.*\n(?:.*\n)*?```", DOCUMENT.read_text(), re.MULTILINE)
    monkeypatch.chdir(reproduced.parents[1])
    names = {}
    exec(block.removesuffix("```"), names)
    assert names["units"]["power_total_w"] == "W"
    assert names["units"]["speed_m_s"] == "m/s"
    assert "northern-bald-ibis" in names["sweep"]
