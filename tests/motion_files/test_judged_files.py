"""A motion file judged as its receiver plays it: as the plan it is of, as another library plays it, as jumps demand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import BPoly, CubicHermiteSpline, CubicSpline
from scipy.signal import lsim

from nospill.certification.certificate import certify, certify_joints
from nospill.errors import ScenarioError
from nospill.export import EXPORTERS
from nospill.motion.interpolation import CUBIC_HERMITE, JointSamples, linear_at
from nospill.motion.resampling import resampled
from nospill.motion_files.judging import JudgedMotion, judge
from nospill.motion_files.receivers import RECEIVERS
from nospill.plans.plan import Plan


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., Plan]) -> Plan:
    return gentle_plan("matrix-liquid", cargo=1)


@pytest.fixture(scope="module")
def files(plan: Plan, tmp_path_factory: pytest.TempPathFactory) -> dict[float, Path]:
    """JointTrajectory messages of the plan, by points a second; as JSON, which is read in a tenth of YAML's time."""
    folder, found = tmp_path_factory.mktemp("motions"), {}
    for rate in (10.0, 50.0, 1000.0):
        found[rate] = folder / f"at-{rate:g}.json"
        EXPORTERS["joint-trajectory"].write(resampled(plan.trajectory, rate), plan.scene, found[rate])
    return found


@pytest.fixture(scope="module")
def dense(plan: Plan, files: dict[float, Path]) -> JudgedMotion:
    """The densest of them, judged."""
    return judge(files[1000.0], plan.scene)


def test_the_plan_s_own_motion_has_the_plan_s_rows(plan: Plan, dense: JudgedMotion) -> None:
    judged = dense
    assert judged.certificate.ok and judged.failures() == []
    planned = {row.id: row for row in certify(plan.trajectory, plan.scene).rows}
    compared = [row for row in judged.certificate.rows if row.id in planned]
    assert len(compared) == len(judged.certificate.rows) >= 20
    for row in compared:
        if row.constraint != "clearance":  # a bound, which another grid puts elsewhere
            assert row.worst_margin == pytest.approx(planned[row.id].worst_margin, abs=2e-3 * row.size + 1e-6), row.id


def by_scipy(name: str, samples: JointSamples) -> Callable[[np.ndarray], np.ndarray]:
    """The receiver's motion by another library."""
    t, q, v, a = samples.t, samples.position, samples.speed, samples.acceleration
    assert v is not None and a is not None
    if name == "jtc":
        return BPoly.from_derivatives(t, np.stack([q, v, a], axis=1))
    return CubicSpline(t, q, bc_type="clamped")


@pytest.mark.parametrize("name", ["jtc", "cubic"])
def test_sparse_points_are_judged_as_another_library_plays_them(
    name: str, plan: Plan, files: dict[float, Path]
) -> None:
    judged = judge(files[10.0], plan.scene, receiver=name)
    samples = judged.file.samples
    t = np.arange(0.0, samples.t[-1] + 1e-9, 2.5e-4)
    theirs = {row.id: row for row in certify_joints(t, by_scipy(name, samples)(t), plan.scene).rows}
    assert theirs.keys() == {row.id for row in judged.certificate.rows}
    for row in judged.certificate.rows:
        if row.constraint in ("slosh height", "residual height", "joint position", "joint speed", "joint torque"):
            assert row.worst_value == pytest.approx(theirs[row.id].worst_value, abs=1e-3 * row.size), row.id
    heights = [row for row in judged.certificate.rows if row.constraint == "slosh height"]
    assert heights[0].worst_value == pytest.approx(theirs[heights[0].id].worst_value, abs=2e-6)


def test_points_that_are_played_otherwise_are_another_motion(plan: Plan, files: dict[float, Path]) -> None:
    """Straight lines between ten points a second: the same places, and jumps of the speed that slide and spill."""
    kind = judge(files[10.0], plan.scene)
    lines = judge(files[10.0], plan.scene, receiver="linear")
    assert not lines.certificate.ok
    worst = {row.id: row for row in lines.certificate.rows}
    for row in kind.certificate.rows:
        if row.constraint in ("slip", "joint acceleration"):
            assert worst[row.id].use > 2.0 * row.use
    codes = {failure["code"]: failure for failure in lines.failures()}
    assert "joint-acceleration" in codes or "slip" in codes
    for failure in lines.failures():
        assert failure["use"] > 1.0 and failure["first_s"] <= failure["worst_s"] + 1e-9
        points = lines.file.samples.t
        assert points[failure["point"] - 1] <= failure["first_s"] + 1e-9
        assert failure["point"] == len(points) or failure["first_s"] < points[failure["point"]] + 1e-9


def test_lines_are_met_at_every_sample_of_the_controller() -> None:
    samples = JointSamples(np.array([0.0, 0.1, 0.3]), np.array([[0.0], [0.2], [-0.2]]))
    motion, t = linear_at(100.0).motion(samples), np.arange(31) / 100.0
    np.testing.assert_allclose(motion(t)[:, 0], np.interp(t, samples.t, samples.position[:, 0]), atol=1e-12)


def test_cubics_have_the_speeds_of_the_points() -> None:
    samples = JointSamples(np.array([0.0, 0.4, 1.0]), np.array([[0.0], [1.0], [0.5]]), np.array([[0.0], [-0.7], [0.0]]))
    motion, t = CUBIC_HERMITE.motion(samples), np.linspace(0.0, 1.0, 101)
    theirs = CubicHermiteSpline(samples.t, samples.position, samples.speed)
    for order in range(3):
        np.testing.assert_allclose(motion(t[:-1], order), theirs(t[:-1], order), atol=1e-12)
    with pytest.raises(ValueError, match="needs speeds"):
        CUBIC_HERMITE.motion(JointSamples(samples.t, samples.position))


def test_receivers_that_take_no_such_points(plan: Plan, files: dict[float, Path]) -> None:
    with pytest.raises(ScenarioError, match="servoj plays a point every 8 ms or less, and points are up to 20 ms"):
        judge(files[50.0], plan.scene, receiver="servoj")
    with pytest.raises(ScenarioError, match=f'"moveit" is no receiver; there are: {", ".join(RECEIVERS)}'):
        judge(files[50.0], plan.scene, receiver="moveit")
    assert judge(files[1000.0], plan.scene, receiver="fci").certificate.ok


def test_a_tray_that_leans_at_the_first_point_is_refused(plan: Plan, tmp_path: Path) -> None:
    samples = resampled(plan.trajectory, 100.0)
    leaning = replace(samples, position=samples.position + 0.02 * np.eye(6)[4])
    EXPORTERS["joint-trajectory"].write(leaning, plan.scene, tmp_path / "leaning.yaml")
    with pytest.raises(ScenarioError, match=r"the tray leans by 1\.15 deg at first"):
        judge(tmp_path / "leaning.yaml", plan.scene)


def test_a_controller_in_the_scene_plays_the_points_late(
    plan: Plan, files: dict[float, Path], dense: JudgedMotion
) -> None:
    """The joints by a first-order lag, as SciPy integrates it, and certified as samples; not the points themselves."""
    lag = 0.03
    scene = plan.scene.changed({"controller": {"lag": lag}})
    judged = judge(files[1000.0], scene)
    assert "the joints follow with the delay and lag of [controller]" in judged.played_text
    command = judged.played.motion(judged.file.samples)
    t = np.arange(0.0, judged.file.samples.t[-1] + 0.5, 5e-4)
    asked = command(t)  # linear between the instants, which is 1e-7 rad off
    followed = np.column_stack([lsim(([1.0], [lag, 1.0]), own - own[0], t)[1] + own[0] for own in asked.T])
    theirs = {row.id: row for row in certify_joints(t, followed, plan.scene).rows}
    exact = {row.id: row for row in dense.certificate.rows}
    apart = 0.0
    for row in judged.certificate.rows:
        if row.constraint in ("slosh height", "slip", "residual height"):
            assert row.worst_value == pytest.approx(theirs[row.id].worst_value, rel=5e-3, abs=2e-5), row.id
            apart = max(apart, abs(row.worst_value / exact[row.id].worst_value - 1.0))
    assert apart > 0.05  # late joints are another motion


def test_tolerances_of_objects_count_for_files_too(plan: Plan, files: dict[float, Path], dense: JudgedMotion) -> None:
    scene = plan.scene.changed({"cargo.0.tolerance": {"liquid_height": "3 mm", "friction": "10 %"}})
    stated = {row.id: row for row in dense.certificate.rows}
    with_tolerance = {row.id: row for row in judge(files[1000.0], scene).certificate.rows}
    assert with_tolerance.keys() == stated.keys()
    worse = [key for key, row in with_tolerance.items() if row.use > stated[key].use + 1e-3 and row.variant]
    assert {key.constraint for key in worse} >= {"slip", "residual height"}
