"""Rows of a run: which take part, what is kept back, and what an objection of the judge changes."""

from __future__ import annotations

from dataclasses import replace

import pytest
from nospill.planning.reserves import first_reserve
from nospill.planning.rows import Rows

from nospill.judge.verdict import Row
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return read_scenario("matrix-liquid")


def row(constraint: str, subject: str, margin: float) -> Row:
    """A row with a limit of 1."""
    return Row(constraint, subject, "1", 1.0, 1.0 - margin, margin, 0.5, margin >= 0.0)


def test_all_take_part_but_those_that_are_ignored_or_known_beforehand(scene):
    rows = Rows.of(scene, frozenset({"slip"}))
    names = {name for name, _ in rows.kept}
    assert rows.kept == rows.all and {"slosh height", "twist", "joint speed"} <= names
    assert not {"slip", "joint position"} & names
    assert not any(name == "slip" for name, _ in rows.active)
    leaning = replace(scene, motion=replace(scene.motion, tilt_free=True))
    assert ("joint position", 0) in Rows.of(leaning, frozenset()).all


def test_rows_far_from_their_limit_are_left_to_the_judge_and_come_back_when_he_objects(scene):
    rows = Rows.of(scene, frozenset())
    key = ("slip", 1)
    rows.keep_near([row("slip", "c2", 0.31), row("slip", "c1", 0.29), row("path position", "tray", 0.9)])
    assert key not in rows.kept and ("slip", 0) in rows.kept
    before = dict(rows.reserves)
    assert rows.answer([row("slip", "c2", -0.01)])
    assert key in rows.kept and rows.reserves == before  # to take part may be enough
    assert rows.answer([row("slip", "c2", -0.01)])
    assert rows.reserves[key] > before[key] + 0.01
    assert rows.raised() == {"slip | c2": rows.reserves[key]}


def test_there_is_nothing_to_act_on_where_the_record_or_an_ignored_constraint_fails(scene):
    rows = Rows.of(scene, frozenset({"slip"}))
    assert not rows.answer([row("path position", "tray", -0.1), row("slip", "c1", -0.1)])


def test_close_rows_by_what_is_left_of_each(scene):
    rows = Rows.of(scene, frozenset({"slip"}))
    slack = {("slosh height", 0): 0.2, ("slosh height", 1): 0.4, ("slip", 0): 0.0}
    assert rows.close(slack) == {("slosh height", 0)}


def test_what_is_known_of_reserves_goes_to_a_tray_in_another_order_and_never_lowers_them(scene):
    rows = Rows.of(scene, frozenset())
    rows.reserves["tip", 3] = 0.07
    turned = replace(scene, cargo=scene.cargo[::-1])
    other = Rows.of(turned, frozenset())
    other.recall(rows.labelled() | {"slip | c1": 0.0, "slip | of nobody": 0.5})
    assert other.reserves["tip", 0] == 0.07
    assert other.reserves["slip", 3] == first_reserve("slip")
    assert other.raised() == {"tip | c4": 0.07}
