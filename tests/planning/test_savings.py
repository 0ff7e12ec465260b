"""What a wider limit would save, from the multipliers, against plans with that limit two percent wider."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.scenario import scene_from_table

PART = 0.02
"""Of the limit; savings are stated for a tenth."""
TOLERANCE = 0.3
"""Of what was foretold: first order only, and another back-off or number of rounds moves a duration by some tenths of a
millisecond a percent."""


def _faster_joint(table: dict[str, Any], found: Plan, subject: str) -> None:
    robot = found.scene.robot
    speeds = robot.max_speed.tolist()
    speeds[robot.joints.index(subject)] *= 1.0 + PART
    table["robot"] = {**table["robot"], "limits": {**table["robot"].get("limits", {}), "speed": speeds}}


def _higher_liquids(table: dict[str, Any], found: Plan, _: str) -> None:
    for entry, cargo in zip(table["cargo"], found.scene.cargo, strict=True):
        if cargo.filling is not None:
            entry["max_slosh_height"] = (1.0 + PART) * cargo.filling.max_slosh_height


def _more_friction(table: dict[str, Any], found: Plan, _: str) -> None:
    for entry, cargo in zip(table["cargo"], found.scene.cargo, strict=True):
        entry["friction"] = (1.0 + PART) * cargo.friction


CHANGES: dict[str, Callable[[dict[str, Any], Plan, str], None]] = {
    "joint speed": _faster_joint,
    "slosh height": _higher_liquids,
    "slip": _more_friction,
}


@pytest.mark.slow
@pytest.mark.parametrize("example", ["matrix-liquid-soft-end", "pp-two-cups"])
def test_a_plan_with_a_wider_limit_saves_what_was_foretold(example: str, example_plan: Callable[[str], Plan]) -> None:
    found = example_plan(example)
    assert len(found.report.savings) >= 2
    for label, saved in found.report.savings.items():
        constraint, _, subject = label.partition(" | ")
        table = found.scene.source
        CHANGES[constraint](table, found, subject)
        wider = plan(scene_from_table(table, name=found.scene.name))
        assert wider.certificate.ok
        assert found.duration - wider.duration == pytest.approx(10.0 * PART * saved, rel=TOLERANCE), label


@pytest.mark.slow
def test_savings_are_spoken_of_and_kept(example_plan: Callable[[str], Plan], tmp_path: Any) -> None:
    import nospill as ns

    found = example_plan("matrix-liquid-tilt")
    assert found.savings_text.startswith("a limit wider by 10 % would save about 0.02")
    assert "(speed of joint 1)" in found.savings_text
    found.save(tmp_path / "plan")
    assert ns.load_plan(tmp_path / "plan").savings_text == found.savings_text
