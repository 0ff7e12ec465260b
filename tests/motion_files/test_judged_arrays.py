"""Motions judged from arrays and trajectories: as from a file, and what the judge saw of them as a plan."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import nospill as ns
from nospill.export import EXPORTERS
from nospill.motion.resampling import resampled
from tests.own_limits import Sideways


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., ns.Plan]) -> ns.Plan:
    return gentle_plan("matrix-liquid", cargo=1)


def arrays(plan: ns.Plan) -> dict[str, np.ndarray]:
    motion = plan.trajectory
    return {"t": motion.t, "q": motion.joint_position}


def test_arrays_a_trajectory_and_a_file_say_the_same(plan: ns.Plan, tmp_path) -> None:
    path = tmp_path / "motion.yaml"
    EXPORTERS["joint-trajectory"].write(resampled(plan.trajectory, plan.trajectory.rate), plan.scene, path)
    of_file = ns.judge(path, plan.scene, receiver="quintic").certificate
    backwards = {name: values[:, ::-1] if name == "q" else values for name, values in arrays(plan).items()}
    named = {**backwards, "joint_names": np.array(plan.scene.robot.joints[::-1])}
    for motion in (plan.trajectory, arrays(plan), named):
        found = ns.judge(motion, plan.scene).certificate
        assert [row.id for row in found.rows] == [row.id for row in of_file.rows]
        for row, other in zip(found.rows, of_file.rows, strict=True):
            assert row.worst_margin == pytest.approx(other.worst_margin, abs=1e-5 * row.size + 1e-9), row.id


def test_it_says_what_it_is(plan: ns.Plan) -> None:
    judged = ns.judge(arrays(plan), plan.scene)
    assert repr(judged) == f"<JudgedMotion of arrays: {plan.trajectory.t[-1]:.3f} s, {judged.certificate.word}>"
    lines = judged.text().splitlines()
    assert lines[0].startswith("read: ") and lines[-1].startswith("not judged: path, ")
    assert any(line.startswith("slosh height") and line.endswith(" s") for line in lines)


def test_its_record_is_that_of_the_plan_it_was(plan: ns.Plan) -> None:
    """Tray, tilt and liquids from the joints alone, at the instants of the plan's own record."""
    record, own = ns.judge(plan.trajectory, plan.scene).plan.trajectory, plan.trajectory
    count = len(own.t)
    np.testing.assert_allclose(record.t[:count], own.t, atol=1e-12)
    np.testing.assert_allclose(record.joint_position[:count], own.joint_position, atol=1e-12)
    np.testing.assert_allclose(record.tray_position[:count], own.tray_position, atol=1e-9)
    np.testing.assert_allclose(record.tilt[:count], own.tilt, atol=1e-9)
    assert record.s[0] == 0.0 and record.s[-1] == 1.0 and np.all(np.diff(record.s) >= 0.0)
    assert list(record.slosh) == list(own.slosh) != []
    for name, track in record.slosh.items():
        seen = plan.history("slosh height", name)
        np.testing.assert_allclose(track.height[:count], np.interp(own.t, seen.t, seen.demand), atol=1e-9)


def test_its_histories_and_figures_are_those_of_what_was_judged(plan: ns.Plan) -> None:
    motion = {**arrays(plan), "t": 0.8 * plan.trajectory.t}
    judged = ns.judge(motion, plan.scene)
    assert not judged.certificate.ok and judged.plan.status == "uncertified"
    for row in judged.certificate.rows:
        if row.constraint == "slosh height":
            assert np.max(judged.plan.history(row.constraint, row.subject).use) == pytest.approx(row.use, abs=1e-12)
    with pytest.raises(ns.ScenarioError, match="no history 'path'"):
        judged.plan.history("path", "deviation")
    assert judged.plan.plot("slosh-heights").axes


def test_what_is_no_motion_is_refused_by_what_it_is(plan: ns.Plan) -> None:
    good = arrays(plan)
    for motion, says in [
        (3.0, "judge takes a file, a Trajectory, or arrays by name"),
        ((good["t"], good["q"]), 'arrays by name as {"t": t, "q": q}, not a value of type tuple'),
        ({"q": good["q"]}, "has no time for every point"),
        ({"t": good["t"]}, "no array of joint positions"),
        ({"t": good["t"], "q": good["q"][:, :4]}, "4 columns without names where the robot has 6 joints"),
        ({"t": good["t"][:-1], "q": good["q"]}, "rows of positions, "),
        ({"t": good["t"], "q": np.degrees(good["q"])}, "degrees"),
        ({"t": good["t"], "q": [["a"]]}, "arrays: q is no table of numbers"),
        ({"t": good["t"], "q": np.full_like(good["q"], np.nan)}, "not a finite number"),
    ]:
        with pytest.raises(ns.ScenarioError) as error:
            ns.judge(motion, plan.scene)  # pyright: ignore[reportArgumentType]
        assert says in str(error.value), error.value
        assert "\n" not in str(error.value)
    with pytest.raises(ns.ScenarioError, match="judge takes a Scene"):
        ns.judge(good, "matrix-liquid")  # pyright: ignore[reportArgumentType]
    with pytest.raises(ns.ScenarioError, match='base_yaw = "free" is for the planner to choose'):
        ns.judge(good, plan.scene.changed({"robot.base_yaw": "free"}))


def test_limits_of_ones_own_are_judged_and_have_histories(plan: ns.Plan) -> None:
    own = Sideways(0.1)
    judged = ns.judge(plan.trajectory, plan.scene, constraints=[own])
    rows = [row for row in judged.certificate.rows if row.constraint == own.name]
    assert rows
    for row in rows:
        history = judged.plan.history(row.constraint, row.subject)
        assert np.max(history.use) == pytest.approx(row.use, abs=1e-9)
