"""The record of a plan: what it says of itself, what survives the folder, and which row is nearest to its limit."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.certification.certificate import Judgement, judge
from nospill.certification.verdict import Certificate, Row, limit_use
from nospill.certification.wording import describe, shown_unit
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export.plan_files import compare_plan_files
from nospill.laws.constraints import BY_NAME
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, Starts, motion_maxima
from nospill.plans.summary import SUMMARY_KEYS, failed_summary
from nospill.plans.warnings.record import PlanWarning
from nospill.scenario import read_scenario
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record, with_few_speeds


def row(constraint: str, value: float, limit: float, margin: float, unit: str = "m", subject: str = "c1") -> Row:
    return Row(constraint, subject, unit, limit, value, margin, 0.5, margin >= 0.0)


@pytest.fixture(scope="module")
def judged() -> tuple[Plan, Judgement]:
    """A slow smooth motion of the liquid experiment; no solver is involved."""
    scene = read_scenario("matrix-liquid")
    path = joint_path_of(scene, samples=41)
    trajectory = smooth_record(scene, path, 40, Start(stretch=1.5))
    judgement = judge(trajectory, scene)
    starts = Starts(2, 2, 1, (1.8, 1.9))
    report = PlanningReport(1.0, 0.5, 10, 1, starts, {"solve": 0.5}, "solved", {"slip | c1": 0.004})
    maxima = motion_maxima(judgement, scene)
    plan = with_few_speeds(Plan(scene, trajectory, judgement.certificate, maxima, report, judgement))  # once
    return plan, judgement


# --- the row nearest to its limit -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("constraint", "limit", "margin", "use"),
    [
        ("slosh height", 0.015, 0.003, 0.8),
        ("slosh height", 0.015, -0.015, 2.0),
        ("joint speed", -2.0, 0.5, 0.75),
        ("lift", 0.0, 0.8, 0.2),
        ("unknown", 0.0, 0.25, 0.75),
        # A joint's zero says nothing: a limit of exactly zero measures margins as one of a half turn does.
        ("joint position", 0.0, np.pi / 2, 0.5),
        ("joint position", 1e-6, np.pi / 2, 0.5),
        ("joint position", 0.0, 0.0, 1.0),
        ("joint position", 47.0, 47.0, 0.0),
    ],
)
def test_use_of_a_limit(constraint: str, limit: float, margin: float, use: float) -> None:
    assert limit_use(BY_NAME.get(constraint), limit, margin) == pytest.approx(use)
    assert row(constraint, 0.0, limit, margin).use == pytest.approx(use)
    assert limit_use(BY_NAME.get(constraint), np.full(3, limit), np.full(3, margin)) == pytest.approx(np.full(3, use))


def test_a_margin_that_is_no_number_is_the_worst() -> None:
    assert limit_use(BY_NAME["slip"], 1.0, np.nan) == np.inf


@given(
    st.sampled_from(["lift", "joint position", "slip", "path jerk"]),
    st.floats(-100, 100).map(lambda limit: limit if abs(limit) > 1e-9 else 0.0),
    st.floats(-10, 10),
    st.floats(1e-6, 1),
)
def test_use_falls_as_the_margin_grows_and_is_one_at_the_limit(
    constraint: str, limit: float, margin: float, more: float
) -> None:
    assert limit_use(BY_NAME.get(constraint), limit, margin + more) <= limit_use(BY_NAME.get(constraint), limit, margin)
    assert (limit_use(BY_NAME.get(constraint), limit, margin) > 1.0) == (margin < 0.0) or abs(margin) < 1e-12
    assert limit_use(BY_NAME.get(constraint), limit, 0.0) == 1.0


def test_limits_of_zero_are_neither_far_nor_near_by_themselves() -> None:
    rows = (
        row("slosh height", 0.012, 0.015, 0.003),
        row("lift", 0.9, 0.0, 0.9, "weight"),
        row("joint position", -1.0, 0.0, 1.0, "rad", "joint_3"),
    )
    assert Certificate(True, 2000.0, rows).worst.constraint == "slosh height"
    near = (*rows[:2], row("joint position", -0.01, 0.0, 0.01, "rad", "joint_3"))
    assert Certificate(True, 2000.0, near).worst.constraint == "joint position"
    light = (rows[0], row("lift", 0.01, 0.0, 0.01, "weight"), rows[2])
    assert Certificate(True, 2000.0, light).worst.constraint == "lift"


def test_a_broken_row_comes_before_any_other() -> None:
    rows = (row("slip", 0.9999, 1.0, 1e-4, "1"), row("lift", -1e-9, 0.0, -1e-9, "weight"))
    certificate = Certificate(False, 2000.0, rows)
    assert certificate.worst is rows[1]
    again = Certificate(False, 2000.0, (*rows, row("slip", 0.5, 1.0, 0.5, "1"), row("slip", 1.1, 1.0, -0.1, "1", "c2")))
    assert [item.subject for item in again.worst_rows()] == ["c2", "c1"]


# --- the words ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given_row", "phrase"),
    [
        (
            row("slosh height", 0.0149957, 0.015, 4.3e-6),
            "slosh height of c1 is 14.996 mm against a limit of 15 mm (99.9 % of it) at t = 0.500 s",
        ),
        (
            row("slosh height", 0.0162, 0.015, -0.0012),
            "slosh height of c1 is 16.2 mm against a limit of 15 mm (108.0 % of it) at t = 0.500 s",
        ),
        (row("slip", 0.99994, 1.0, 6e-5, "1"), "slip of c1 uses 99.9 % of its limit at t = 0.500 s"),
        (row("slip", 360.8, 1.0, -359.8, "1"), "slip of c1 uses 36080 % of its limit at t = 0.500 s"),
        (
            row("joint position", -0.01, 0.0, 0.01, "rad", "joint_3"),
            "joint position of joint_3 is −0.573 deg against a limit of 0 deg (0.573 deg left) at t = 0.500 s",
        ),
        (
            row("joint position", 2.98, 2.97, -0.01, "rad", "joint_1"),
            "joint position of joint_1 is 171 deg against a limit of 170 deg (0.573 deg beyond) at t = 0.500 s",
        ),
        (
            row("lift", -0.2, 0.0, -0.2, "weight"),
            "lift of c1 is −0.2 weight against a lower limit of 0 weight (0.2 weight beyond) at t = 0.500 s",
        ),
        (
            row("path attitude", 2e-4, 1e-4, -1e-4, "rad", "tray"),
            "path attitude of tray is 0.2 mrad against a limit of 0.1 mrad (200.0 % of it) at t = 0.500 s",
        ),
        (
            row("path covered", 0.5, 1e-9, -0.5, "1", "path"),
            "path covered of path is 0.5 against a limit of 1e−09 (over 1000000 % of it) at t = 0.500 s",
        ),
    ],
)
def test_a_row_in_words(given_row: Row, phrase: str) -> None:
    assert describe(given_row) == phrase


@given(st.floats(1e-12, 1e-3))
def test_only_the_very_limit_is_a_hundred_per_cent(distance: float) -> None:
    assert "100.00 %" not in describe(row("slip", 1.0 - distance, 1.0, distance, "1"))
    assert "100.00 %" not in describe(row("slip", 1.0 + distance, 1.0, -distance, "1"))


@pytest.mark.parametrize(
    ("unit", "limit", "factor", "shown"),
    [
        ("m", 0.015, 1e3, "mm"),
        ("rad", 0.5, 180 / np.pi, "deg"),
        ("rad", 0.0, 180 / np.pi, "deg"),
        ("rad", -1e-4, 1e3, "mrad"),
        ("rad/s", 1e-3, 1e3, "mrad/s"),
        ("rad/s", -2.4, 180 / np.pi, "deg/s"),
        ("rad/s^3", 1000.0, 1.0, "rad/s^3"),
        ("1", 1.0, 100.0, "%"),
        ("1", 1e-9, 1.0, ""),
        ("weight", 0.0, 1.0, "weight"),
    ],
)
def test_units_as_shown(unit: str, limit: float, factor: float, shown: str) -> None:
    assert shown_unit(unit, limit) == (pytest.approx(factor), shown)


def test_message_is_one_sentence_that_tells_the_use(judged: tuple[Plan, Judgement]) -> None:
    plan, _ = judged
    message = plan.message
    assert message.startswith("Certified" if plan.certificate.ok else "Not certified: ")
    assert describe(plan.certificate.worst) in message and "\n" not in message


# --- the summary and the folder -------------------------------------------------------------------------------------


def test_summaries_have_the_same_keys_in_the_same_order(judged: tuple[Plan, Judgement]) -> None:
    plan, _ = judged
    assert tuple(plan.summary()) == SUMMARY_KEYS
    failed = failed_summary("tea", "no way")
    assert tuple(failed) == SUMMARY_KEYS
    stated = {key: value for key, value in failed.items() if value is not None}
    assert stated == {"scenario": "tea", "status": "failed", "message": "no way"}


@pytest.mark.slow
def test_a_plan_comes_back_from_its_folder(judged: tuple[Plan, Judgement], tmp_path: Path) -> None:
    plan, judgement = judged
    plan.save(tmp_path / "out")
    back = load_plan(tmp_path / "out")
    assert back.judgement is None
    assert back.certificate == plan.certificate
    assert back.maxima == plan.maxima
    assert back.report == plan.report
    assert back.duration == plan.duration
    assert np.array_equal(back.trajectory.joint_position, plan.trajectory.joint_position)
    assert back.summary() == plan.summary()
    assert back.maxima.survival is not None and back.survival_text.startswith("survives ")
    # What the folder holds is judged as the plan was, to the bit.
    assert judge(back.trajectory, back.scene).certificate == judgement.certificate


@pytest.mark.slow
def test_the_judgement_is_evidence_and_no_part_of_the_record(judged: tuple[Plan, Judgement], tmp_path: Path) -> None:
    plan, _ = judged
    bare = dataclasses.replace(plan, judgement=None)
    assert "judgement" not in repr(plan)
    one, other, again = (PlanWarning(name, "c1", "", 1.0, 0.0) for name in ("crest", "mass", "mass"))
    assert repr(dataclasses.replace(plan, warnings=(one,))).endswith("s, certified as published, 1 warning>")
    assert repr(dataclasses.replace(plan, warnings=(one, other, again))).endswith(", 2 warnings>")
    for name, one in (("a", plan), ("b", bare)):
        one.save(tmp_path / name)
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


@pytest.mark.parametrize("name", ["certificate.json", "summary.json"])
def test_json_nested_beyond_reason_is_one_line(judged: tuple[Plan, Judgement], tmp_path: Path, name: str) -> None:
    judged[0].save(tmp_path / "out")
    (tmp_path / "out" / name).write_text("[" * 200_000 + "]" * 200_000)
    with pytest.raises(PlanFolderError, match=r"damaged .*nested too deeply") as caught:
        load_plan(tmp_path / "out")
    assert len(str(caught.value)) < 500


def test_byte_order_marks_are_read(judged: tuple[Plan, Judgement], tmp_path: Path) -> None:
    judged[0].save(tmp_path / "out")
    for path in (tmp_path / "out").iterdir():
        path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert load_plan(tmp_path / "out").certificate == judged[0].certificate
    compared = compare_plan_files(judged[0].trajectory, judged[0].scene, tmp_path / "out")
    assert compared and not any(compared.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["scenario.toml", "trajectory.csv", "certificate.json", "summary.json"])
@pytest.mark.parametrize("damage", ["missing", "empty", "cut", "binary"])
def test_damaged_folders_are_one_line(judged: tuple[Plan, Judgement], tmp_path: Path, name: str, damage: str) -> None:
    judged[0].save(tmp_path / "out")
    path = tmp_path / "out" / name
    if damage == "missing":
        path.unlink()
    elif damage == "empty":
        path.write_bytes(b"")
    elif damage == "cut":
        path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    else:
        path.write_bytes(b"\xff\xfe\x00" * 50)
    with pytest.raises((PlanFolderError, ScenarioError)) as caught:
        load_plan(tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert str(tmp_path / "out") in str(caught.value)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("summary.json", {"starts": None}),
        ("summary.json", {"max_tilt_deg": "much"}),
        ("summary.json", {"backoff": {"slip | c1": "much"}}),
        ("summary.json", {"backoff": 3}),
        ("summary.json", {"warnings": [1]}),
        ("summary.json", {"warnings": [{"name": "crest"}]}),
        ("certificate.json", {"rows": [1]}),
        ("certificate.json", {"rows": []}),
        ("certificate.json", {"rows": [{}]}),
    ],
)
def test_folders_with_other_content_are_refused(
    judged: tuple[Plan, Judgement], tmp_path: Path, name: str, change: dict[str, object]
) -> None:
    judged[0].save(tmp_path / "out")
    path = tmp_path / "out" / name
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(PlanFolderError, match="damaged"):
        load_plan(tmp_path / "out")


def test_a_time_that_may_be_too_short_is_said_of_a_plan_that_is_not_certified(gentle_plan) -> None:
    plan = gentle_plan("matrix-liquid-soft-end", 1)
    failed = dataclasses.replace(plan, certificate=dataclasses.replace(plan.certificate, ok=False))
    assert "too short" not in failed.message
    tight = dataclasses.replace(failed, scene=plan.scene.changed({"motion.max_duration": "1.4 s"}))
    assert "motion.max_duration = 1.4 s may be too short" in tight.message
