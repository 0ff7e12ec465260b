"""What a run teaches, as tables of a scenario."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.execution.executed import executed
from nospill.execution.log import JointLog
from nospill.identification.identified import Identified, identified, identified_table, scenario_text
from nospill.motion.control import followed
from nospill.plans.plan import Plan
from nospill.scenario import scene_from_table
from nospill.scene.controller import Controller
from nospill.simulation.motion_file import Heights
from tests.execution.logs import log_of

DELAY, LAG = 1e-3 * np.array([8.0, 4, 6, 5, 2, 10]), 1e-3 * np.array([15.0, 20, 10, 5, 25, 8])


pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[..., Plan]) -> Plan:
    return gentle_plan("matrix-liquid", cargo=2)


@pytest.fixture(scope="module")
def log(plan: Plan) -> JointLog:
    """A run with its command in the log, as RTDE records it."""
    command, length = plan.trajectory.motion, float(plan.trajectory.t[-1])
    controller = Controller(DELAY, LAG, compensate=False)
    t = np.arange(0.0, length + 1.5, 0.002)
    done = followed(command, controller, 0.0, length)(t - 0.5 - controller.latest)
    noise = 1e-6 * np.random.default_rng(0).standard_normal(done.shape)
    return JointLog("run.csv", t, plan.scene.robot.joints, done + noise, command(t - 0.5))


@pytest.fixture(scope="module")
def found(plan: Plan, log: JointLog) -> Identified:
    seen = executed(log, plan.scene)
    t = np.arange(-0.4, 5.5, 1 / 60)
    height = np.interp(t, seen.judgement.replay.t, seen.heights["c1"], left=0.0)
    noise = 3e-4 * np.random.default_rng(1).standard_normal(len(t))
    return identified(log, plan.scene, measured={"c1": Heights(t, height + noise)}, stayed=["c1"], slid=["c2"])


def test_controllers_of_the_scenario_are_learnt_again(found: Identified) -> None:
    assert found.of_command
    assert not found.unexplained
    for fit, delay, lag in zip(found.joints, DELAY, LAG, strict=True):
        if fit.moves:
            assert fit.delay.value == pytest.approx(delay, abs=1e-3)
            assert fit.lag.value == pytest.approx(lag, rel=0.05)


def test_the_tables_are_read_by_a_scenario(found: Identified, plan: Plan) -> None:
    tables = tomllib.loads(scenario_text(found))
    scene = scene_from_table({**plan.scene.source, **tables}, name="learnt")
    assert scene.controller is not None
    assert scene.controller.lag[[0, 2]] == pytest.approx(LAG[[0, 2]], rel=0.05)
    others = np.delete(scene.controller.lag, 3)
    assert scene.controller.lag[3] == pytest.approx(np.mean(others), abs=1e-5)  # it does not move


def test_what_stayed_and_what_slid_bound_the_friction(found: Identified) -> None:
    stayed, slid = found.frictions
    assert (stayed.subject, stayed.slid, slid.subject, slid.slid) == ("c1", False, "c2", True)
    assert 0.0 < stayed.friction < found.scene.cargo[0].planned_friction
    text = scenario_text(found)
    assert f"# c1 stayed: friction above {stayed.friction:.3f}." in text
    assert f"# c2 slid: friction below {slid.friction:.3f}." in text


def test_what_the_motion_does_not_tell_is_said(found: Identified) -> None:
    assert {own.subject for own in found.unidentifiable} >= {"joint_4"}
    text = scenario_text(found)
    assert "the mean of the other joints stands where this motion does not tell" in text
    if not found.liquids[0].of("fill").identifiable:
        assert "fill not identifiable from this motion" in text


def test_the_record_is_plain(found: Identified) -> None:
    table = identified_table(found)
    assert table["joints"]["joint_4"]["lag"] == {"value": 0.0, "half_width": None, "unit": "s", "identifiable": False}
    assert table["liquids"]["c1"]["clock"]["identifiable"]
    assert [own["slid"] for own in table["friction"]] == [False, True]


def test_a_plan_takes_the_place_of_the_command(plan: Plan, log: JointLog) -> None:
    found = identified(replace(log, command=None), plan.scene, plan=plan)
    assert not found.of_command
    moving = [index for index, fit in enumerate(found.joints) if fit.moves]
    told = np.array([found.joints[index].delay.value for index in moving])
    assert told == pytest.approx(DELAY[moving] - np.min(DELAY[moving]), abs=1e-3)


def test_what_no_lag_explains_is_said(plan: Plan, log: JointLog) -> None:
    assert log.command is not None
    hunting = log.position.copy()
    hunting[:, 0] += 1e-3 * np.sin(40.0 * log.t) * np.abs(np.gradient(hunting[:, 0])) * 500.0
    found = identified(replace(log, position=hunting), plan.scene)
    assert found.unexplained and [fit.unexplained for fit in found.joints] == [True] + 5 * [False]


def test_nothing_to_learn_from_is_refused(plan: Plan) -> None:
    with pytest.raises(ScenarioError, match=r"nothing to learn from: give measured heights \(--measured\)"):
        identified(log_of(plan), plan.scene)
    with pytest.raises(ScenarioError, match="--stayed or --slid c9: no such object; there are: c1, c2"):
        identified(log_of(plan), plan.scene, stayed=["c9"])
