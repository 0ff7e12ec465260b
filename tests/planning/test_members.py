"""Which variants join a problem, and whom the rows of the others concern."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.verdict import Row
from nospill.laws.constraints.base import RowId
from nospill.planning.members import Members
from nospill.planning.row_backoff import backoff_by_order, crests_of, relaxed_by_order, tightened
from nospill.planning.tightening import growth_by_order, relaxed_second_order
from nospill.planning.worst_speeds import is_far
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.scene.variants import variants_by_object


def _with_range(scene: Scene, least: float) -> Scene:
    return replace(scene, motion=replace(scene.motion, speed_range=(least, 1.0)))


def test_the_example_of_two_like_cups() -> None:
    """As the module tells it: the worst variant of each joins, the others are for the rows in the problem."""
    uses = {("c1", ""): 1.004, ("c1", "+2 mm"): 1.020, ("c2", "+2 mm"): 1.018, ("c2", "-2 mm"): 1.003}
    members = Members({("c1", ""): "c1"}, dict.fromkeys(uses, 1.0), read_scenario("matrix-liquid").cargo[:2], 4)
    rows = [
        Row("slosh height", name, "m", 1.0, use, 1.0 - use, 0.0, use <= 1.0, text) for (name, text), use in uses.items()
    ]
    backoff = {RowId("slosh height", "c1"): 0.0}
    found = members.missing(rows, above=1.005, outer=["c1"], backoff=backoff, t=np.array([0.0, 1.0]))
    assert found == {("c1", "+2 mm"), ("c2", "+2 mm")}
    beside = [row for row in rows if (row.subject, row.variant) not in found]
    assert {row.id for row in members.attributed(beside, own=False)} == backoff.keys()
    assert [row.use for row in members.attributed(rows, own=True)] == [1.004]
    more, joining = tightened(members.attributed(beside, own=False), backoff.keys(), backoff, {})
    assert more[RowId("slosh height", "c1")] > 0.004 and not joining


def test_peaks_beside_which_back_off_is_in_vain_join(smooth_motion: Callable) -> None:
    """A residual height between two members joins where it is well above, or one of them keeps nearly all back."""
    scene = smooth_motion("mixed-tray").scene
    cup = replace(next(item for item in scene.cargo if item.oscillators), name="a")
    speeds = {("a", ""): 1.0} | {("a", str(speed)): speed / 10 for speed in range(3, 10)}
    names = {("a", ""): "a", ("a", "4"): "a at 4", ("a", "8"): "a at 8"}
    uses = {"3": 0.2, "4": 0.9, "5": 0.95, "6": 1.05, "7": 0.9, "8": 0.8, "9": 0.7}

    def joining(constraint: str, worst: float, **kept: float) -> set[str]:
        peak = {**uses, "6": worst}
        rows = [Row(constraint, "a", "m", 1.0, use, 1.0 - use, 0.0, use <= 1.0, at) for at, use in peak.items()]
        backoff = {RowId(constraint, f"a at {number[1:]}"): value for number, value in kept.items()}
        t = np.array([0.0, 0.01])  # no speed is far from another
        found = Members(names, speeds, (cup,), 4).missing(rows, above=1.005, outer=["a"], backoff=backoff, t=t)
        return {text for _, text in found}

    assert joining("residual height", 1.2, _4=0.3, _8=0.5) == {"6"}
    assert joining("residual height", 1.05, _4=0.3, _8=0.5) == set()
    assert joining("residual height", 1.05, _4=0.3, _8=0.9) == {"6"}
    assert joining("residual height", 0.99, _4=0.3, _8=0.9) == set()
    assert joining("slosh height", 1.05, _4=0.3, _8=0.9) == set()


def test_slowed_liquids_join_from_the_planned_speed_downwards(smooth_motion: Callable) -> None:
    """As many as there are members at a time, below the slowest at even steps of 1/v, above it at peaks."""
    cup = replace(next(item for item in smooth_motion("mixed-tray").scene.cargo if item.oscillators), name="a")
    slowest, t = min(mode.frequency for mode in cup.oscillators), np.array([0.0, 2.0])
    step = math.pi / (slowest * t[-1])
    slow = {("a", f"{number}"): 1.0 / (1.0 + 0.25 * number * step) for number in range(1, 61)}
    speeds, names = {("a", ""): 1.0} | slow, {("a", ""): "a"}

    def joined(uses: Callable[[int], float]) -> list[int]:
        rows = [
            Row("residual height", "a", "m", 1.0, use, 1.0 - use, 0.0, use <= 1.0, text)
            for (_, text), use in ((variant, uses(int(variant[1]))) for variant in slow)
        ]
        members = Members(names, speeds, (cup,), 4)
        found = members.missing(rows, above=1.005, outer=["a"], backoff={}, t=t)
        names.update({variant: f"a at {variant[1]}" for variant in found})
        return sorted(int(text) for _, text in found)

    first = joined(lambda _: 2.0)
    assert len(first) == 4 and first[0] <= 3 and np.all(np.diff(first) == 4)
    second = joined(lambda number: 0.9 if number <= first[-1] else 2.0)
    assert len(second) == len(first) + 1 and second[0] > first[-1] + 1 and np.all(np.diff(second) <= 5)
    peak = first[0] + 2
    assert joined(lambda number: 2.0 if number == peak else 0.9) == [peak]
    assert joined(lambda number: 1.05 if number == first[1] + 2 else 0.9) == []  # the back-off of those beside it does


def test_solids_join_wherever_they_break_a_limit(smooth_motion: Callable) -> None:
    """They bring no states; objects with liquids join where they are well over it."""
    scene = _with_range(smooth_motion("mixed-tray").scene, 0.5)
    families = variants_by_object(scene)
    speeds = {item.id: item.speed for own in families for item in own}
    names = {own[0].id: own[0].name for own in families}
    (solid,) = (own[0].name for own in families if not own[0].cargo.oscillators)

    def joining(use: float) -> set[str]:
        slowed = [item for own in families for item in own[1:]]
        rows = [Row("slip", item.name, "1", 1.0, use, 1.0 - use, 0.0, use <= 1.0, item.text) for item in slowed]
        found = Members(names, speeds, scene.cargo, 4).missing(
            rows, above=1.5, outer=[], backoff={}, t=np.array([0.0, 2.0])
        )
        return {name for name, _ in found}

    assert joining(0.99) == set() and joining(1.01) == {solid} and joining(1.6) > {solid}


def test_a_peak_far_from_all_slowed_members_joins(smooth_motion: Callable) -> None:
    """Back-off of members more than half of pi / (omega T) in 1/v away says nothing of it; nearer ones keep it."""
    cargo = smooth_motion("mixed-tray").scene.cargo
    slowest = min(mode.frequency for item in cargo for mode in item.oscillators)
    t = np.array([0.0, 2.0])
    half = 0.5 * math.pi / (slowest * t[-1])
    for away, expected in ((1.1, {"at"}), (0.9, set())):
        speeds = {("a", ""): 1.0, ("a", "b"): 0.5, ("a", "at"): 1.0 / (2.0 + away * half), ("a", "end"): 0.2}
        names = {("a", ""): "a", ("a", "b"): "a at b"}
        uses = {"b": 0.9, "at": 1.02, "end": 0.3}
        rows = [
            Row("residual height", "a", "m", 1.0, use, 1.0 - use, 0.0, use <= 1.0, text) for text, use in uses.items()
        ]
        assert {text for _, text in Members(names, speeds, cargo, 4).far_peaks(rows, t)} == expected
        assert Members({("a", ""): "a"}, speeds, cargo, 4).far_peaks(rows, t) == set()  # nothing is slowed yet
    assert not is_far(0.3, [("a", "")], {("a", ""): 1.0}, 0.1)


def test_heights_of_second_order_are_tightened_by_the_root_of_a_quadratic() -> None:
    """What the optimiser leaves out goes with the square: 0.6 of the limit with 0.4 x 0.36/0.64 more, not 0.6 + 0.4."""
    key = RowId("slosh height", "a")

    def row(linear: float, second: float) -> Row:
        return Row(*key, "m", 1.0, second, 1.0 - second, 0.0, second <= 1.0, linear_value=linear)

    backoff, joining = tightened([row(0.9, 1.1)], [key], {key: 0.1}, {})
    kept = 1.0 - backoff[key]
    assert not joining and kept + 0.2 / 0.81 * kept**2 == pytest.approx(0.98, abs=0.005)  # half of 4 % below the limit
    assert backoff_by_order([row(0.9, 1.1)], {key: 0.1}) == backoff
    assert backoff_by_order([row(0.9, 0.99)], {key: 0.1}) == {}
    again, _ = tightened([row(0.8, 1.0001)], [key], {key: 0.2}, {})
    assert 0.2 < again[key] < 0.21
    given = relaxed_by_order([row(0.6, 0.7)], {key: 0.4})
    assert 0.15 < given[key] < 0.4
    assert relaxed_by_order([row(0.6, 0.97)], {key: 0.4}) == {key: 0.4}


def test_heights_that_fall_less_than_the_law_says_are_tightened_by_the_secant() -> None:
    """1 - 0.05 b of the limit, with 0.003 more: a twentieth of what the law takes a step of the back-off to bring."""
    key = RowId("slosh height", "a")
    backoff, crests, rounds = {key: 0.0}, dict[RowId, tuple[float, float]](), 0
    while (second := 1.003 - 0.05 * backoff[key]) > 1.0:
        rows = [Row(*key, "m", 1.0, second, 1.0 - second, 0.0, False, linear_value=1.0 - backoff[key])]
        following, _ = tightened(rows, [key], backoff, {}, crests)
        crests, backoff = crests_of(rows, backoff), following
        rounds += 1
    assert rounds <= 7
    assert backoff[key] < 0.12  # no farther than a little below the limit
    alone = {key: 0.0}
    for _ in range(rounds):
        second = 1.003 - 0.05 * alone[key]
        rows = [Row(*key, "m", 1.0, second, 1.0 - second, 0.0, False, linear_value=1.0 - alone[key])]
        alone, _ = tightened(rows, [key], alone, {})
    assert 1.003 - 0.05 * alone[key] > 1.0


def test_over_a_band_a_crest_far_below_its_limit_gets_back_off_back_beside_its_margin() -> None:
    """own h + added h^2 = 1 less what the band adds, of which the linear height keeps less: what is left is used."""
    linear, second, band = 0.5, 0.6, 0.1
    kept = band / growth_by_order(linear, second)
    assert growth_by_order(linear, second) == pytest.approx(1.4)
    backoff = 1.0 - kept - linear  # the problem's row was active
    relaxed = relaxed_second_order(backoff, linear, second, band)
    height = 1.0 - relaxed - kept
    assert 0.85 < height + 0.4 * height**2 + band < 1.0
    assert relaxed_second_order(backoff, linear, second, 0.36) == backoff  # none where the band takes the rest
    assert growth_by_order(0.1, 0.6) == 3.0  # turns of the tray drive it
