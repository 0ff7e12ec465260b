"""The approach as the judge sees it: the limits, the ends, the cargo; and every way to spoil it is noticed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from benchmarks.itself.independent import least_rooms
from benchmarks.itself.run import RESOLUTION
from nospill.approach import find_approach, judge_segment, read_segment, segment_text
from nospill.approach.search import SLOWEST
from nospill.certification.clearance import OTHERS
from nospill.certification.verdict import APPROACH
from nospill.collisions.pairs import scene_pairs
from nospill.errors import PlanFolderError
from nospill.scene.scene import Scene

LEVEL = [0.5, 0.0, 0.0, 0.0, 0.0, 0.0]
"""rad; only joint_1 turns, about the vertical: the tray stays level."""
LEANING = [0.3, 0.0, 0.0, 0.0, 0.8, 0.0]
"""rad; joint_5 starts with the tray leaning by 46 deg, which no friction here bears."""


def failed(certificate) -> set[str]:
    return {row.constraint.removeprefix(APPROACH) for row in certificate.rows if not row.ok}


def test_an_empty_tray_goes_as_fast_as_the_scales_allow(requested):
    question = requested()
    found = find_approach(question.scene, question.rules, question.end)
    assert found.certificate.ok and found.segment.stretch == 1.0
    assert {row.constraint for row in found.certificate.rows if row.constraint.endswith("height")} == set()
    speeds = np.max(np.abs(found.segment.samples.speed), axis=0) / question.rules.max_speed  # pyright: ignore[reportArgumentType, reportCallIssue]
    assert np.max(speeds) <= 0.5 * (1 + 1e-9)
    quick = requested(speed_scale=1.0, acceleration_scale=1.0)
    faster = find_approach(quick.scene, quick.rules, quick.end)
    assert faster.certificate.ok
    assert faster.segment.duration < found.segment.duration


def test_a_loaded_tray_is_slowed_down_until_the_liquid_bears_it(requested):
    question = requested(shift=LEVEL, tray="loaded")
    found = find_approach(question.scene, question.rules, question.end)
    assert found.certificate.ok
    assert 1.0 < found.segment.stretch < SLOWEST
    named = {row.constraint.removeprefix(APPROACH) for row in found.certificate.rows}
    assert {"slip", "tip", "lift", "slosh height", "residual height"} <= named
    empty = requested(shift=LEVEL)
    at_once = find_approach(empty.scene, empty.rules, empty.end).segment
    verdict = judge_segment(replace(at_once, loaded=True), question.scene, question.rules, question.end)
    assert not verdict.ok
    assert failed(verdict) <= {"slip", "slosh height", "residual height"}


def test_a_lean_that_friction_does_not_bear_is_refused_at_any_speed(requested):
    question = requested("matrix-rigid", shift=LEANING, tray="loaded")
    found = find_approach(question.scene, question.rules, question.end)
    assert not found.certificate.ok
    assert found.segment.stretch == SLOWEST
    assert "slip" in failed(found.certificate)
    # At rest |f_T| / N is the tangent of the lean: 46 deg against 0.9 times the friction of tan 25 deg.
    slip = max(row.worst_value for row in found.certificate.rows if row.constraint == "approach slip")
    assert slip == pytest.approx(np.tan(0.8) / (0.9 * 0.466308), rel=0.05)


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.lists(st.floats(0.02, 0.98), min_size=6, max_size=6), st.sampled_from([0.1, 0.5, 1.0]))
@example(parts=[0.5] * 6, scale=0.5)  # free
@example(parts=[0.5, 0.75, 0.125, 0.5, 0.5, 0.5], scale=0.5)  # the tray passes through the base
def test_from_anywhere_within_the_limits_an_empty_tray_arrives(requested, parts, scale):
    """But for what a straight line in joint space meets: the arm itself and its tray, as coal sees them too."""
    question = requested()
    scene, robot = question.scene, question.scene.robot
    start = robot.lower + np.array(parts) * (robot.upper - robot.lower)
    rules = replace(question.rules, start=start, speed_scale=scale, acceleration_scale=scale)
    blind = replace(scene, robot=replace(robot, self_collision=False))
    found = find_approach(blind, rules, question.end)
    assert found.certificate.ok and found.segment.stretch == 1.0, failed(found.certificate)
    assert np.array_equal(found.segment.samples.position[0], start)
    assert np.array_equal(found.segment.samples.position[-1], question.end)
    seeing = judge_segment(found.segment, scene, rules, question.end)
    assert failed(seeing) <= {"clearance"}
    margins = {row.subject: row.worst_margin for row in seeing.rows if row.constraint == "approach clearance"}
    for pair, room in rooms_by_coal(scene, start, question.end).items():
        margin = margins[pair if pair in margins else OTHERS]  # that of all others is of the nearest
        assert margin <= room + RESOLUTION
        assert pair not in margins or room < 0.0 or margin > 0.9 * room - BETWEEN  # a bound, a tenth too low at most


BETWEEN = 5e-3
"""m; half of what a part of the arm moves at most between two instants at which coal is asked."""


def rooms_by_coal(scene: Scene, start: np.ndarray, end: np.ndarray) -> dict[str, float]:
    """Least distance, m, of each judged pair on the straight line, beside what estimated capsules may overlap.

    The holder is left out, of which the oracle has no shape.
    """
    q = start + np.linspace(0.0, 1.0, 801)[:, None] * (end - start)
    names = [pair.subject.split(" to ") for pair in scene_pairs(scene, loaded=False)]
    rooms = least_rooms(scene, q, {(first, second) for first, second in names if first != "holder"})
    return {f"{first} to {second}": room for (first, second), room in rooms.items()}


@pytest.fixture(scope="module")
def good(requested):
    question = requested()
    return question, find_approach(question.scene, question.rules, question.end).segment


def spoilt(segment, **columns):
    return replace(segment, samples=replace(segment.samples, **columns))


def test_a_segment_that_ends_elsewhere_is_noticed(good):
    question, segment = good
    for end, wanted in ((question.end + 2e-6, {"end"}), (question.end + 0.5e-6, set())):
        assert failed(judge_segment(segment, question.scene, question.rules, end)) == wanted
    moved = replace(question.rules, start=question.rules.start + 2e-6)
    assert failed(judge_segment(segment, question.scene, moved, question.end)) == {"start"}


def test_a_sample_that_jumps_is_noticed(good):
    question, segment = good
    position = segment.samples.position.copy()
    position[200, 3] += 1e-3
    found = failed(judge_segment(spoilt(segment, position=position), question.scene, question.rules, question.end))
    assert {"joint acceleration", "joint jerk", "recorded speed"} <= found


def test_a_motion_cut_off_is_not_at_rest(good):
    question, segment = good
    cut = {name: getattr(segment.samples, name)[:-50] for name in ("t", "position", "speed", "acceleration")}
    found = failed(judge_segment(spoilt(segment, **cut), question.scene, question.rules, question.end))
    assert {"end", "rest at the ends"} <= found


def test_tighter_limits_are_noticed_each_by_its_row(good):
    question, segment = good
    for field, name in (("max_speed", "speed"), ("max_acceleration", "acceleration"), ("max_jerk", "jerk")):
        rules = replace(question.rules, **{field: 0.3 * getattr(question.rules, field)})
        assert failed(judge_segment(segment, question.scene, rules, question.end)) == {f"joint {name}"}
    low = question.scene.robot.lower.copy()
    low[4] = np.radians(-95.0)
    scene = replace(question.scene, robot=replace(question.scene.robot, lower=low))
    assert failed(judge_segment(segment, scene, question.rules, question.end)) == {"joint position"}


def test_the_file_is_read_back_to_the_bit(good, tmp_path):
    _, segment = good
    path = tmp_path / "approach.csv"
    path.write_text(segment_text(segment))
    back = read_segment(path, segment.joints, loaded=False, stretch=1.0)
    for name in ("t", "position", "speed", "acceleration"):
        assert np.array_equal(getattr(back.samples, name), getattr(segment.samples, name))


@pytest.mark.parametrize("damage", ["missing", "empty", "cut", "word", "header", "backwards"])
def test_damaged_files_are_one_line(good, tmp_path, damage):
    _, segment = good
    path, text = tmp_path / "approach.csv", segment_text(segment)
    lines = text.splitlines()
    if damage == "backwards":
        lines[3], lines[4] = lines[4], lines[3]
    if damage == "header":
        lines[0] = lines[0].replace("joint_2", "elbow")
    if damage == "word":
        lines[5] = lines[5].replace(",", ",much", 1)
    if damage == "cut":
        lines[-1] = lines[-1][:40]
    if damage != "missing":
        path.write_text("" if damage == "empty" else "\n".join(lines))
    with pytest.raises(PlanFolderError) as caught:
        read_segment(path, segment.joints, loaded=False, stretch=1.0)
    assert "approach.csv" in str(caught.value) and "\n" not in str(caught.value)
