"""What an arm is known for, beside what a plan survives; and what the advice leads to."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from nospill.certification.known_arm import beside
from nospill.certification.survival import Looked, delay_fault, survived
from nospill.certification.survived import Survival, Survived
from nospill.certification.tracked_rows import Followed
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.robots.description.catalog import ROBOTS, load_robot
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene

BOTTLE: dict[str, Any] = {
    "robot": {"model": "franka-fr3"},
    "tray": {"size": [0.22, 0.17], "friction": 0.45, "friction_reserve": 0.1, "mass": 0.3, "offset": 0.08},
    "cargo": [{"name": "bottle", "at": [0.0, 0.0], "shape": "cylinder", "radius": 0.03, "height": 0.1, "mass": 0.3}],
    "path": {"type": "line", "start": [0.45, -0.3, 0.45], "end": [0.45, 0.3, 0.4], "yaw": ["0 deg", "60 deg"]},
    "motion": {"tilt": "free"},
}
"""Tilts so far that late joints let it slide."""


def surviving(delay: float | None) -> Survival:
    return Survival(Survived(delay), Survived(None), Survived(None))


def cup(model: str, **tables: Any) -> Scene:
    """That it stands still at the end goes with no band."""
    table = {
        "name": "cup", "at": [0.0, 0.0], "shape": "cylinder", "radius": 0.035, "height": 0.099, "liquid": "water",
        "liquid_height": 0.049, "empty_mass": 0.1, "max_slosh_height": 0.015,
    }  # fmt: skip
    changed = {"robot": {"model": model}, "cargo": [table], "motion": {"end": "published"}, **tables}
    return scene_from_table({**BOTTLE, **changed}, name="cup")


def test_of_an_arm_measured_as_one_it_says_what_nobody_knows() -> None:
    scene = cup("ur10e")
    assert beside(surviving(1e-3), scene) == (
        "this arm is known for 34 ms in all joints alike (servoj), which only shifts the time; between its joints "
        "nothing is known of this arm: measure it (nospill identify), or state tolerance.tracking"
    )
    assert not beside(surviving(None), scene)


def test_less_than_the_arm_is_known_for_asks_for_a_band() -> None:
    scene = cup("franka-fr3")
    known = "this arm is known for 0.3 to 3.1 ms between joints (franka-sim's servo with feed-forward)"
    assert beside(surviving(2.7e-3), scene) == (
        f'{known}: state tolerance.tracking.delay = "2.8 ms" and motion.end = "residual"'
    )
    for enough in (2.9e-3, None):
        assert beside(surviving(enough), scene) == f"{known}, which it survives"


def test_nothing_is_added_where_the_scenario_says_how_late_the_arm_is() -> None:
    assert not beside(surviving(0.0), cup("franka-fr3", controller={"lag": "5 ms"}))


@pytest.mark.parametrize("name", ROBOTS)
def test_known_figures_are_sourced_and_increase(name: str) -> None:
    for item in load_robot(name).tracking:
        assert item.by
        assert item.source
        assert 0.0 <= item.late[0] <= item.late[1] < 0.2
        assert (item.between is None) == (item.late[0] == item.late[1])


@pytest.mark.slow
def test_the_advice_leads_to_a_plan_that_survives_what_the_arm_is_known_for() -> None:
    def advised(made: Plan) -> tuple[Survived, str]:
        followed = Followed.of(made.trajectory, made.scene, made.certificate.rows)
        delay = survived(Looked.at(followed), delay_fault(followed))
        return delay, beside(replace(surviving(None), delay=delay), made.scene)

    scene = scene_from_table({**BOTTLE, "planning": {"intervals": 30}}, name="bottle")
    delay, advice = advised(plan(scene))
    assert delay.size is not None
    assert delay.size < 2.8e-3
    key, value = advice.partition(": state ")[2].split(" = ")
    following, said = advised(plan(scene.changed({key: value.strip('"')})))
    assert following.size is None or following.size > 2.8e-3
    assert said.endswith(", which it survives")
