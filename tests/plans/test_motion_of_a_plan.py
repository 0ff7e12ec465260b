"""A plan's motion, histories and figures as values: what the judge saw, before and after the folder."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from types import ModuleType

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from nospill.certification.certificate import judge
from nospill.core.attitudes import matrices
from nospill.errors import ScenarioError
from nospill.motion.holds import held_trajectory
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., Plan]) -> Plan:
    return gentle_plan("matrix-liquid", cargo=2)


@pytest.fixture(scope="module")
def loaded(plan: Plan, tmp_path_factory: pytest.TempPathFactory) -> Plan:
    folder = tmp_path_factory.mktemp("plans") / "matrix-liquid"
    plan.save(folder)
    return load_plan(folder)


def test_the_trajectory_is_the_motion_that_is_judged(plan: Plan) -> None:
    played = plan.evidence.replay
    for order, column in enumerate((played.joint_position, played.joint_speed, played.joint_acceleration)):
        np.testing.assert_allclose(plan.trajectory(played.t, order), column, rtol=0, atol=1e-12)


def test_holds_change_the_motion_between_them_by_rounding_alone(plan: Plan) -> None:
    """The judge's spline goes on through the holds; the trajectory's knows that the arm stands there."""
    rules = replace(plan.scene.motion, hold_before=0.2, hold_after=0.1)
    held, t = held_trajectory(plan.trajectory, rules), np.linspace(plan.trajectory.t[0], plan.trajectory.t[-1], 5000)
    for order, least in enumerate((1e-11, 1e-8, 1e-5)):
        np.testing.assert_allclose(plan.trajectory(t, order), held(t, order), rtol=0, atol=least)


def test_the_tray_is_where_the_joints_carry_it(plan: Plan) -> None:
    trajectory = plan.trajectory
    tray = plan.tray(trajectory.t)
    np.testing.assert_allclose(tray.position, trajectory.tray_position, atol=1e-6)
    np.testing.assert_allclose(tray.rotation, matrices(trajectory.tray_quaternion), atol=1e-6)
    middle, aside = float(trajectory.t[len(trajectory.t) // 2]), 1e-4
    one = plan.tray(middle)
    assert (one.position.shape, one.rotation.shape) == ((3,), (3, 3))
    before, after = plan.tray(middle - aside), plan.tray(middle + aside)
    np.testing.assert_allclose((after.position - before.position) / (2 * aside), one.velocity, atol=1e-6)
    np.testing.assert_allclose((after.velocity - before.velocity) / (2 * aside), one.acceleration, atol=1e-4)
    with pytest.raises(ScenarioError, match="outside the motion"):
        plan.tray(1e3)


def test_every_row_of_the_certificate_has_a_history(plan: Plan) -> None:
    assert plan.histories == tuple(row.id for row in plan.certificate.rows)
    for row in plan.certificate.rows:
        assert np.max(plan.history(*row.id).use) == row.use


def test_a_plan_from_a_folder_is_judged_once_and_gives_the_same(
    plan: Plan, loaded: Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []
    monkeypatch.setattr("nospill.plans.plan.judge", lambda *given: calls.append(given) or judge(*given))
    pairs = [(plan.history("slosh height", "c1"), loaded.history("slosh height", "c1"))]
    pairs += [(plan.contact("c2"), loaded.contact("c2")), (plan.modes("c1"), loaded.modes("c1"))]
    for ours, theirs in pairs:
        for item in fields(ours):
            np.testing.assert_array_equal(getattr(ours, item.name), getattr(theirs, item.name))
    assert len(calls) <= 1


def test_an_unknown_history_says_what_there_is(plan: Plan) -> None:
    with pytest.raises(ScenarioError, match=r"'slosh height' of 'c3'; there are c1, c2$"):
        plan.history("slosh height", "c3")


@pytest.mark.parametrize("name", ["joints", "slosh-heights", "margins", "tray"])
def test_a_figure_is_a_value(plan: Plan, name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is written, no setting of matplotlib and no window is touched."""
    monkeypatch.chdir(tmp_path)
    before, pyplot = dict(matplotlib.rcParams), _pyplot()
    figure = plan.plot(name)
    assert isinstance(figure, Figure)
    panels = [axes for axes in figure.axes if axes.axison]
    assert panels and all(axes.get_title(loc="left") or axes.get_ylabel() for axes in panels)
    assert any("[" in axes.get_xlabel() + axes.get_ylabel() for axes in panels), "a unit"
    assert dict(matplotlib.rcParams) == before and _pyplot() is pyplot
    if pyplot is not None:
        assert pyplot.get_fignums() == []
    assert list(tmp_path.iterdir()) == []
    figure.savefig(tmp_path / "figure.png")  # by whoever wants it


def _pyplot() -> ModuleType | None:
    return sys.modules.get("matplotlib.pyplot")


def test_plots_lists_what_plot_draws(plan: Plan) -> None:
    assert {"joints", "summary", "path"} <= set(plan.plots)
    with pytest.raises(ScenarioError) as caught:
        plan.plot("joint")
    assert str(caught.value) == f"no figure 'joint': did you mean 'joints'? there are {', '.join(plan.plots)}"
    with pytest.raises(ScenarioError, match="'distances' does not apply to matrix-liquid"):
        plan.plot("distances")
