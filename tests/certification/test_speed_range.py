"""Motions that must hold at every speed of a range: what is judged, and at which speeds others join the problem."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nospill.certification import corners
from nospill.certification.certificate import judge_motion
from nospill.certification.corners import _LOOKS, _at_speeds, broken_or_corner_traces, closer, corner_traces, vertices
from nospill.certification.other_speeds import uses_at
from nospill.certification.replay import MINIMUM_RATE, Replay
from nospill.certification.tracks import variant_tracks
from nospill.certification.verdict import Row
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import Role, RowId
from nospill.planning.log import Log
from nospill.planning.refinement import Judged
from nospill.planning.shortening import _with_whole_verdict
from nospill.planning.worst_speeds import adjacent_members, evenly, peaks
from nospill.scene.cargo import Tolerance
from nospill.scene.scene import SPEED_STEP
from nospill.scene.tolerances import corner_scenes
from nospill.scene.variants import variants_by_object

AS_JUDGED = None, MINIMUM_RATE, None


def with_range(scene, least: float, greatest: float = 1.0):
    return replace(scene, motion=replace(scene.motion, speed_range=(least, greatest)))


def test_speeds_of_a_range_are_close_to_each_other(smooth_motion: Callable) -> None:
    scene = with_range(smooth_motion("mixed-tray").scene, 0.25)
    speeds = scene.motion.speeds
    assert speeds[-1] == 0.25 and speeds[0] < 1.0
    steps = np.diff(1.0 / np.array([1.0, *speeds]))
    assert np.all(steps > 0.0) and np.all(steps < SPEED_STEP + 2e-4)  # speeds are rounded
    assert with_range(scene, 0.5, 0.8).motion.speeds[0] == 0.8
    assert replace(scene.motion, speed_range=None).speeds == ()


def test_solids_are_tried_at_both_ends_and_liquids_at_every_speed(smooth_motion: Callable) -> None:
    scene = with_range(smooth_motion("mixed-tray").scene, 0.9)
    count = len(scene.motion.speeds)
    families = {own[0].name: own for own in variants_by_object(scene)}
    assert len(families["cup"]) == 1 + count and len(families["bottle"]) == 3
    assert families["cup"][-1].id == ("cup", "90 % of the speed")
    assert families["cup"][-1].cargo_at_speed.speed == 0.9 and families["cup"][0].cargo_at_speed is scene.cargo[0]


def test_rows_of_a_range_are_the_uses_at_its_speeds(smooth_motion: Callable) -> None:
    """Against the look at other speeds, which knows nothing of variants."""
    motion = smooth_motion("mixed-tray", stretch=0.8, tilt=(0.1, 0.05))
    scene = with_range(motion.scene, 0.9)
    judgement = judge_motion(motion.trajectory, scene)
    for speed in scene.motion.speeds[::4]:
        (use,) = uses_at(motion.trajectory, motion.scene, [speed])
        text = f"{100 * speed:.4g} % of the speed"
        rows = [row for row in judgement.corners if row.variant == text]  # further ones are between the speeds
        first = {(row.constraint, row.subject): row for row in reversed(rows)}.values()
        liquid = max(row.use for row in first if BY_NAME[row.constraint].role is Role.LIQUID)
        assert liquid == pytest.approx(use.liquid, rel=1e-6)
    worst = max((row for row in judgement.corners if row.constraint == "slosh height"), key=lambda row: row.use)
    assert 0.0 <= worst.at_s <= motion.trajectory.end_time + 1e-9  # on the planned motion's clock
    torque = [row for row in judgement.corners if row.constraint == "joint torque"]
    assert {row.variant for row in torque} <= {"90 % of the speed"}


def test_a_first_look_ends_where_it_breaks_a_limit(smooth_motion: Callable) -> None:
    """Of every third speed and both ends, uses as the judge finds them there; where those hold, of all of the grid."""
    motion = smooth_motion("mixed-tray", stretch=0.8, tilt=(0.1, 0.05))
    scene = with_range(motion.scene, 0.7)
    whole = judge_motion(motion.trajectory, scene)
    first = judge_motion(motion.trajectory, scene, corners=broken_or_corner_traces)
    judged, looked_at = uses_of_variants(whole.corners), uses_of_variants(first.corners)
    assert not whole.certificate.ok and not first.certificate.ok
    variants = {variant for _, subject, variant in looked_at if subject == "cup"}
    speeds = {f"{100 * speed:.4g} % of the speed" for speed in scene.motion.speeds}
    assert {"", "70 % of the speed"} <= variants <= {"", *speeds} and len(variants) < 0.4 * len(speeds) + 3
    liquids = {row for row in looked_at if BY_NAME[row[0]].role is Role.LIQUID}
    for row, use in looked_at.items():
        assert use == pytest.approx(judged[row], abs=(5e-4 if row in liquids else 0.02) * max(1.0, use))


def uses_of_variants(rows: tuple[Row, ...]) -> dict[tuple[str, str, str], float]:
    return {(row.constraint, row.subject, row.variant): row.use for row in rows}


def test_planning_ends_with_the_whole_verdict_over_a_range(smooth_motion: Callable) -> None:
    motion = smooth_motion("mixed-tray", stretch=0.8, tilt=(0.1, 0.05))
    scene = with_range(motion.scene, 0.9)
    first = judge_motion(motion.trajectory, scene, corners=broken_or_corner_traces)
    candidate: Any = SimpleNamespace(active=SimpleNamespace(task=SimpleNamespace(scene=scene)))
    last = _with_whole_verdict(Judged(candidate, motion.trajectory, first), Log(None, 60.0)).judgement
    assert last.corners == judge_motion(motion.trajectory, scene).corners and len(last.corners) > len(first.corners)


def test_a_motion_that_holds_is_looked_at_as_it_is_judged(smooth_motion: Callable) -> None:
    motion = smooth_motion("mixed-tray", stretch=3.0)
    scene = with_range(motion.scene, 0.95)
    whole, looked_at = (
        [(trace.id, trace.variant, trace.use) for trace in law(motion.trajectory, scene, *AS_JUDGED)]
        for law in (corner_traces, broken_or_corner_traces)
    )
    assert [row[:2] for row in whole] == [row[:2] for row in looked_at]
    assert all(np.array_equal(a[2], b[2]) for a, b in zip(whole, looked_at, strict=True))
    assert max(np.max(use) for *_, use in whole) < 1.0


def test_where_every_third_speed_holds_the_others_are_looked_at(
    smooth_motion: Callable, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = smooth_motion("mixed-tray", stretch=3.0)
    scene = with_range(motion.scene, 0.95)
    texts = [f"{100 * speed:.4g} % of the speed" for speed in scene.motion.speeds]
    monkeypatch.setattr(corners, "_is_broken", lambda trace: trace.variant == texts[1])
    found = [trace for trace in broken_or_corner_traces(motion.trajectory, scene, *AS_JUDGED) if trace.subject == "cup"]
    assert {trace.variant for trace in found} == {"", *texts}
    assert all(len(trace.t) == 1 for trace in found)  # what their rows need, and no more


def test_speeds_that_broke_a_limit_are_looked_at_again_before_all_others(
    smooth_motion: Callable, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = smooth_motion("mixed-tray", stretch=3.0)
    scene = with_range(motion.scene, 0.7)
    again = scene.motion.speeds[7:9]
    texts = {f"{100 * speed:.4g} % of the speed" for speed in again}
    monkeypatch.setattr(corners, "_is_broken", lambda trace: trace.variant in texts)
    found = list(broken_or_corner_traces(motion.trajectory, scene, *AS_JUDGED, again=again))
    assert {trace.variant for trace in found if trace.subject == "cup"} == texts


def test_what_comes_nearest_to_a_limit_is_judged_before_the_rest(
    smooth_motion: Callable, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where a first look says that it holds and the judge that it does not, the rest is not looked at."""
    motion = smooth_motion("mixed-tray", stretch=0.8, tilt=(0.1, 0.05))
    scene = with_range(motion.scene, 0.9)
    whole = uses_of_variants(judge_motion(motion.trajectory, scene).corners)
    monkeypatch.setattr(corners, "_is_broken", lambda _: False)
    monkeypatch.setattr(corners, "_LEFT", 1.0 - 0.99 * max(whole.values()))
    found = uses_of_variants(judge_motion(motion.trajectory, scene, corners=broken_or_corner_traces).corners)
    assert max(found.values()) == max(whole.values()) > 1.0 and found.items() < whole.items()


def test_what_is_no_number_at_a_first_look_is_judged(smooth_motion: Callable, monkeypatch: pytest.MonkeyPatch) -> None:
    def diverged(*given: Any, **more: Any) -> tuple[Replay, ...]:
        (played,) = coarse_replays(*given, **more)
        return (replace(played, slosh_displacement=np.full_like(played.slosh_displacement, np.nan)),)

    coarse_replays = corners.coarse_replays
    monkeypatch.setattr(corners, "coarse_replays", diverged)
    motion = smooth_motion("mixed-tray", stretch=3.0)
    scene = with_range(motion.scene, 0.95)
    assert judge_motion(motion.trajectory, scene, corners=broken_or_corner_traces).certificate.ok


def test_liquids_of_slow_motions_start_a_problem_in_its_own_time(smooth_motion: Callable) -> None:
    """Rates of displacements on the clock of the planned motion."""
    motion = smooth_motion("mixed-tray", stretch=0.8, tilt=(0.1, 0.05))
    scene = with_range(motion.scene, 0.5)
    chosen = ("cup", "50 % of the speed")
    track = variant_tracks(motion.trajectory, scene, {chosen: "slow"})["slow"]
    found = np.gradient(track.displacement, motion.trajectory.t, axis=0)[2:-2]
    assert np.allclose(found, track.velocity[2:-2], atol=2e-2 * np.abs(track.velocity).max())


def test_peaks_are_local_and_of_the_worst_object() -> None:
    speeds = {("a", ""): 1.0} | {(name, str(speed)): speed / 10 for name in "ab" for speed in range(1, 10)}

    def row(name: str, speed: int, use: float, constraint: str = "slip") -> Row:
        return Row(constraint, name, "1", 1.0, use, 1.0 - use, 0.0, use <= 1.0, str(speed))

    uses = {1: 0.2, 2: 0.5, 3: 0.9, 4: 0.8, 5: 0.8, 6: 1.5, 7: 1.2, 8: 0.1, 9: 0.4}
    rows = [row("a", speed, use) for speed, use in uses.items()] + [row("b", 7, 1.7), row("b", 3, 0.1)]
    found = {(item.subject, item.variant) for item in peaks([*rows, row("a", 5, 2.0, "tip")], speeds)}
    assert found == {("a", "3"), ("b", "7"), ("a", "9"), ("a", "5")}


def test_even_steps_of_slowness_hold_the_worst_object_at_each() -> None:
    """Between 1/v = 1.25 and 4 in steps of at most 0.5: seven speeds, each the nearest of those that were judged."""
    values = [round(0.8 * 0.99**index, 6) for index in range(117)]
    speeds = {(name, f"{value}"): value for name in "ab" for value in values}

    def row(name: str, value: float, use: float) -> Row:
        return Row("residual height", name, "m", 1.0, use, 1.0 - use, 0.0, use <= 1.0, f"{value}")

    rows = [row("a", value, 2.0) for value in values] + [row("b", value, 3.0) for value in values if value < 0.4]
    found = evenly(rows, speeds, 0.5)
    slowness = np.array([1.0 / speeds[item.subject, item.variant] for item in found])
    assert len(found) == math.ceil((1 / values[-1] - 1 / values[0]) / 0.5) + 1
    assert np.abs(np.diff(slowness)).max() < 0.5 * 1.05 and slowness.max() == pytest.approx(1 / values[-1])
    assert all((item.subject == "b") == (item.use == 3.0) == (float(item.variant) < 0.4) for item in found)
    assert evenly([], speeds, 0.5) == []

    members = [("a", ""), *(("a", f"{value}") for value in values[:20:5])]
    known = speeds | {("a", ""): 1.0}
    assert adjacent_members(values[7], members, known) == [("a", f"{values[5]}"), ("a", f"{values[10]}")]
    assert adjacent_members(values[50], members, known) == [("a", f"{values[15]}")]
    assert adjacent_members(values[7], members[:1], known) == []


@pytest.mark.parametrize("at", np.linspace(3.7, 3.7 + SPEED_STEP, 9).tolist())
def test_looks_between_speeds_find_a_narrow_peak(at: float) -> None:
    """One as narrow as the steps of 1/v, wherever it stands between two of them."""

    def use(speed: float) -> float:
        return 0.985 + 0.0145 * math.exp(-(((1.0 / speed - at) / SPEED_STEP) ** 2))

    known = {1.0 / slowness: use(1.0 / slowness) for slowness in (3.7 + SPEED_STEP * np.arange(-2, 4)).tolist()}
    for look in (closer, *_LOOKS * (vertices,)):
        known |= {speed: use(speed) for speed in look(known)}
    assert max(known.values()) > use(1.0 / at) - 5e-5


def test_no_look_between_speeds_far_from_a_limit_or_over_it() -> None:
    for most in (0.96, 1.01):
        use = {0.5: 0.9, 0.51: most, 0.52: 0.9}
        assert closer(use) == set() == vertices(use)
    assert len(closer({0.5: 0.9, 0.51: 0.99, 0.52: 0.9})) > 10


def test_between_speeds_only_what_asks_and_is_tried_there_is_played(smooth_motion: Callable) -> None:
    """Solids are tried at both ends, which say all of them: none is played between, however near to a limit."""
    corners = list(corner_scenes(with_range(smooth_motion("mixed-tray").scene, 0.5)))
    uses = {(RowId("slip", name), 0): {0.5: 0.99, 0.9877: 0.99} for name in ("bottle", "cup")}
    found = _at_speeds(corners, uses, closer)
    assert len(found) > 100
    assert all([item.name for item in own.scene.cargo] == ["cup"] for own in found)
    assert _at_speeds(corners, {}, closer) == []


def test_between_speeds_only_variants_near_a_limit_are_played(smooth_motion: Callable) -> None:
    scene = smooth_motion("mixed-tray").scene
    level = Tolerance(liquid_height=1e-3)
    cargo = tuple(replace(item, tolerance=level) if item.oscillators else item for item in scene.cargo)
    corners = list(corner_scenes(with_range(replace(scene, cargo=cargo), 0.9)))
    assert {corner.number for corner in corners if corner.speed == 0.9} == {0, 1, 2}
    row = RowId("slosh height", "cup")
    uses = {(row, 0): {0.91: 0.5, 0.9: 0.5}, (row, 1): {0.91: 0.99, 0.9: 0.98}, (row, 2): {0.91: 1.01, 0.9: 0.96}}
    found = _at_speeds(corners, uses, closer)
    assert found and {own.number for own in found} == {1}
    assert {own.texts["cup"].split(",")[0] for own in found} == {"fill -1 mm"}
