"""Problems of carrying: the same for a seed, with a motion that exists; their report."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks.carry import scenes
from benchmarks.carry.families import FAMILIES, Cell, Room
from benchmarks.carry.report import BEGIN, END, write_page
from benchmarks.carry.run import structure
from nospill.scenario import scene_from_table


def open_cell(random: np.random.Generator) -> Cell:
    """A cell with one post that is in nobody's way, so that the search is short."""
    cell = Cell(Room((0.4, -0.3, 0.1), (0.5, -0.2, 0.2)), Room((0.4, 0.2, 0.1), (0.5, 0.3, 0.2)))
    cell.cylinder("post", (-0.6, 0.0, -0.1), 0.05, 0.3)
    return cell


def test_every_family_draws_solids_that_differ_from_seed_to_seed() -> None:
    for name, family in FAMILIES.items():
        cell, again, other = (family(np.random.default_rng(seed)) for seed in (1, 1, 2))
        assert cell == again and cell != other, name
        names = [item["name"] for item in cell.solids]
        assert len(set(names)) == len(names) > 0


def test_a_seed_is_a_problem_with_a_motion(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scenes, "FAMILIES", {"open": open_cell})
    problem, again = scenes.draw_problem(0), scenes.draw_problem(0)
    assert problem is not None
    assert problem == again
    assert problem.slow_s > 0.0
    scene = scene_from_table(json.loads(json.dumps(problem.table)), name="read")
    assert [item.name for item in scene.obstacles] == ["post"]
    assert structure(problem.table).startswith("ur5e, ")


def test_the_page_has_a_row_for_every_group(tmp_path) -> None:
    page = tmp_path / "carrying.md"
    page.write_text(f"before\n{BEGIN}\n{END}\nafter\n", encoding="utf-8")
    head = {"family": "box", "slow_s": 4.0, "singular": False, "blocked": 1, "pathless": 0, "commit": "abc"}
    planned = {
        "kind": "planned",
        "duration_s": 1.0,
        "on_way_s": 2.0,
        "plan_s": 2.0,
        "plan_processor_s": 3.0,
        "touching": 0,
    }
    lines = [
        {**head, **planned, "seed": 3, "structure": "ur5e, 1 liquids, 0 solids, level", "verify": {"ok": True}},
        {
            **head,
            "seed": 10,
            "structure": "ur5e, 1 liquids, 0 solids, tilting",
            "kind": "not found",
            "reason": "No way",
        },
    ]
    write_page(lines, page)
    text = page.read_text(encoding="utf-8")
    assert "| box | 2 | 1 | 50% | 2.0 | 0.50 |" in text
    assert "| not found | No way | 1 | box 1 | 10 |" in text
    assert text.startswith("before\n") and text.endswith("after\n")
