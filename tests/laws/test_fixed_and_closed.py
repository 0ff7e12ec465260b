"""Objects that are fixed and containers with a lid: which limits they have, and that they are felt all the same."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import judge
from nospill.errors import ScenarioError
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import OF_OBJECTS, RowId
from nospill.laws.like_objects import bearable_acceleration, hull_objects
from nospill.laws.scene_parameters import flange_load, numbers_of
from nospill.margins import margins
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene
from nospill.verify import verify

CONTACT = {"lift", "slip", "tip", "twist"}
LIQUID = {"slosh height", "residual height"}
CLOSED = {"lid": True, "max_slosh_height": None}


def cups(**changes: dict[str, Any]) -> Scene:
    """Two cups of water at full fidelity; keys of the cups "left" and "right"."""
    keys = {f"cargo.{name}.{key}": value for name, own in changes.items() for key, value in own.items()}
    return read_scenario("pp-two-cups").changed({"fidelity": "full", **keys})


def limits(scene: Scene, name: str) -> set[str]:
    found = {item.name for item in CONSTRAINTS if item.evaluated_at in OF_OBJECTS and name in item.subjects(scene)}
    return found - {"apparent gravity"}


def test_what_is_fixed_has_no_limit_of_contact_and_what_is_closed_none_of_height() -> None:
    scene = cups(left={"fixed": True}, right=CLOSED)
    assert limits(scene, "left") == LIQUID
    assert limits(scene, "right") == {*CONTACT, "residual height"}  # it may push the cup after the end
    closed = cups(left={"fixed": True, **CLOSED})
    assert limits(closed, "left") == set() and closed.cargo[0].filling is None
    assert closed.cargo[0].total.mass == pytest.approx(cups().cargo[0].total.mass)
    assert limits(cups(), "left") == CONTACT | LIQUID


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"cargo.left.fixed": True, "cargo.left.friction": 0.4}, "friction is given, but fixed = true"),
        ({"cargo.left.lid": True}, "max_slosh_height is given, but under lid = true"),
        ({"cargo.left.lid": True, "cargo.left.max_slosh_height": None, "fidelity": "deliverable"}, 'fidelity = "full"'),
        ({"cargo.left.fixed": "yes"}, "cargo.left.fixed|fixed"),
    ],
)
def test_keys_that_contradict_each_other(changes: dict[str, Any], words: str) -> None:
    with pytest.raises(ScenarioError, match=words) as caught:
        cups().changed(changes)
    assert "\n" not in str(caught.value)
    with pytest.raises(ScenarioError, match="lid = true is given but liquid is not"):
        read_scenario("matrix-rigid").changed({"cargo.c1.lid": True})


def test_they_are_felt_like_loose_and_open_ones(gentle_plan: Callable[..., Plan]) -> None:
    """Weight on the flange and the swing of the liquid are those of the same cup standing free."""
    free = gentle_plan("pp-two-cups")
    scene = free.scene.changed({"fidelity": "full", "planning.slosh_modes": 1})
    held = scene.changed({"cargo.left.fixed": True, "cargo.right.lid": True, "cargo.right.max_slosh_height": None})
    loads = [flange_load(item) for item in (scene, held)]
    assert loads[0].mass == loads[1].mass and np.array_equal(loads[0].inertia, loads[1].inertia)
    judged = [judge(free.trajectory, item) for item in (scene, held)]
    assert np.array_equal(judged[0].replay.slosh_displacement, judged[1].replay.slosh_displacement)
    torques = [[row for row in one.certificate.rows if row.constraint == "joint torque"] for one in judged]
    assert torques[0] == torques[1]
    rows = [{row.id: row for row in one.certificate.rows} for one in judged]
    assert {key.label for key in rows[0].keys() - rows[1].keys()} == {
        *(f"{name} | left" for name in CONTACT),
        "slosh height | right",
    }
    height = RowId("residual height", "right")  # against a limit that follows from the rim
    assert all(row == rows[0][key] for key, row in rows[1].items() if key != height)


def test_a_fixed_object_does_not_stand_for_a_loose_one() -> None:
    scene = read_scenario("matrix-rigid").changed({"cargo.c1.fixed": True})
    assert {item.name for item in hull_objects(scene)} == {"c1", "c2", "c3", "c4"}
    numbers = numbers_of(scene).objects[0]
    assert bearable_acceleration(numbers, fixed=True) == np.inf > bearable_acceleration(numbers)


@pytest.mark.slow
def test_closed_cups_in_a_holder_are_limited_by_the_arm_alone() -> None:
    found = plan(cups(left={"fixed": True, **CLOSED}, right={"fixed": True, **CLOSED})).with_second_looks()
    assert found.certificate.ok and found.duration < 1.2  # 1.9 s where both stand free and open
    assert found.certificate.worst.constraint == "joint speed"
    report = verify(found)
    assert report.ok and max(item.slide.value for item in report.objects) == 0.0
    with pytest.raises(ScenarioError, match="no object has a limit"):
        margins(found, samples=20)
