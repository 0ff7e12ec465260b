"""The loop of docs/after-the-run.md on an arm that nobody here wrote: play, learn its lag, plan with it, play again."""

from __future__ import annotations

import tomllib
from typing import Any

import pytest

from nospill.execution.executed import Executed, executed
from nospill.identification.identified import identified, scenario_text
from nospill.laws.constraints.base import Role
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.scenario import scene_from_table
from tests.franky_loop import played

pytest.importorskip("franky_sim", reason="franky-sim is not installed; make robots does it")

pytestmark = [pytest.mark.slow, pytest.mark.oracle]

TABLE: dict[str, Any] = {
    "robot": {"model": "franka-fr3"},
    "tray": {"size": [0.22, 0.17], "friction": 0.45, "friction_reserve": 0.1, "mass": 0.3, "offset": 0.08},
    "cargo": [
        {
            "name": "cup",
            "at": [0.0, 0.0],
            "shape": "cylinder",
            "radius": 0.035,
            "height": 0.099,
            "liquid": "water",
            "liquid_height": 0.049,
            "empty_mass": 0.1,
            "max_slosh_height": 0.015,
        }
    ],
    "path": {
        "type": "line",
        "start": [0.45, -0.3, 0.45],
        "end": [0.45, 0.3, 0.45],
        "yaw": ["0 deg", "0 deg"],
    },
    "motion": {"end": "residual"},
}
"""A cup on a line in front of the arm."""
BAND = {"tracking": {"delay": "3 ms"}}
"""By which the joints may be off what is learnt of them."""


def _run(made: Plan) -> Executed:
    return executed(played(made), made.scene, plan=made)


@pytest.fixture(scope="module")
def runs() -> tuple[Executed, Executed]:
    """Before and after the arm was learnt."""
    first = plan(scene_from_table(TABLE, name="loop"))
    learnt = identified(played(first), first.scene, plan=first)
    controller = tomllib.loads(scenario_text(learnt))["controller"]
    second = scene_from_table({**TABLE, "controller": controller, "tolerance": BAND}, name="loop")
    return _run(first), _run(plan(second))


def test_what_is_learnt_takes_the_tray_to_its_path(runs: tuple[Executed, Executed]) -> None:
    before, after = (own.tracking for own in runs)
    assert before is not None and after is not None
    assert before.tray_error > 5e-3
    assert after.tray_error < 1e-3


def test_liquid_and_contact_hold_on_the_arm_that_was_learnt(runs: tuple[Executed, Executed]) -> None:
    rows = runs[1].judgement.certificate.rows
    of_cargo = [row for row in rows if row.known is not None and row.known.role in (Role.LIQUID, Role.CONTACT)]
    assert of_cargo
    assert not [row.label for row in of_cargo if row.use > 1.0]
