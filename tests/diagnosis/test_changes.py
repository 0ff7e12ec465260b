"""Suggested changes: made in a scenario's table, and the keys that make room for a constraint."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from nospill.diagnosis.relaxations import Relaxation, relaxations_of
from nospill.diagnosis.search import WITHIN, first_share
from nospill.errors import Change, NospillError
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import RowId
from nospill.laws.scene_parameters import numbers_of
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.settings import changed_table
from nospill.scene.scene import Scene

Changed = Callable[..., Scene]


LEVERS: list[tuple[str, dict[str, Any], str, str, str]] = [
    ("matrix-rigid", {}, "slip", "c2", "tray.friction"),
    ("matrix-rigid", {"cargo.1.friction": 0.2}, "slip", "c2", "cargo.c2.friction"),
    ("matrix-rigid", {"cargo.1.friction": 0.2}, "twist", "c1", "tray.friction"),
    ("matrix-rigid", {}, "tip", "c3", "cargo.c3.centre_of_mass_height"),
    ("matrix-liquid", {"cargo.0.footprint_reserve": 0.3}, "tip", "c1", "cargo.c1.footprint_reserve"),
    ("matrix-liquid", {"cargo.1.max_slosh_height": "9 mm"}, "slosh height", "c2", "cargo.c2.max_slosh_height"),
    ("matrix-liquid", {}, "residual height", "c1", "motion.residual_fraction"),
    ("matrix-rigid", {"robot.limits": {"speed_scale": 0.5}}, "joint speed", "joint_2", "robot.limits.speed_scale"),
    ("matrix-rigid", {"robot.limits": {"speed": 1.0}}, "joint speed", "joint_2", "robot.limits.speed"),
    ("matrix-rigid", {}, "tilt", "theta_x", "motion.max_tilt"),
    ("matrix-rigid", {}, "path jerk", "path", "motion.path_jerk_limit"),
    ("matrix-rigid", {}, "tilt jerk", "theta_y", "motion.tilt_jerk_limit"),
    ("matrix-rigid", {"motion.max_speed": 0.5}, "tray speed", "tray", "motion.max_speed"),
    ("matrix-rigid", {"motion.max_acceleration": 3.0}, "tray acceleration", "tray", "motion.max_acceleration"),
]


@pytest.mark.parametrize(("name", "changes", "constraint", "subject", "place"), LEVERS)
def test_the_scene_of_a_relaxation_is_that_of_its_change(
    name: str, changes: dict[str, Any], constraint: str, subject: str, place: str, changed_scene: Changed
) -> None:
    """What is solved in the trial is what the user gets who writes the suggested value into the file."""
    scene = changed_scene(name, changes)
    relaxation = main_relaxation(scene, constraint, subject)
    share = min(0.25, 0.5 * relaxation.most)
    change = relaxation.change(share)
    assert change.place == place
    tried, written = relaxation.scene(share), scene.changed(change.values)
    assert numbers_text(tried) == numbers_text(written) != numbers_text(scene)
    for limit in ("max_speed", "max_torque", "lower", "upper"):
        ours, theirs = getattr(tried.robot, limit), getattr(written.robot, limit)
        assert (ours is None) == (theirs is None)
        assert ours is None or np.allclose(ours, theirs)


def main_relaxation(scene: Scene, constraint: str, subject: str) -> Relaxation:
    assert subject in BY_NAME[constraint].subjects(scene)
    return relaxations_of(scene, constraint, subject, {RowId(constraint, subject): 1.0})[0]


def numbers_text(scene: Scene) -> str:
    """The numbers the laws read, to nine digits."""
    with np.printoptions(precision=9):
        return repr(_rounded(numbers_of(scene)))


def _rounded(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_rounded(entry) for entry in value)
    if hasattr(value, "__dataclass_fields__"):
        return tuple(_rounded(getattr(value, name)) for name in value.__dataclass_fields__)
    array = np.asarray(value, dtype=float)
    return [float(f"{entry:.9g}") for entry in array.ravel()]


def test_no_limit_is_raised_beyond_the_robots_own(changed_scene: Changed) -> None:
    scene = changed_scene("matrix-rigid", {"robot.limits": {"speed_scale": 0.5}})
    relaxation = main_relaxation(scene, "joint speed", "joint_1")
    assert relaxation.most == pytest.approx(1.0)
    assert (
        relaxations_of(
            changed_scene("matrix-rigid", {}), "joint speed", "joint_1", {RowId("joint speed", "joint_1"): 1.0}
        )
        == []
    )


def test_no_slosh_height_is_suggested_above_the_rim() -> None:
    scene = read_scenario("matrix-liquid")
    relaxation = main_relaxation(scene, "slosh height", "c1")
    assert relaxation.most == pytest.approx((99.1 - 49.0) / 15.0 - 1.0)
    assert scene.changed(relaxation.change(relaxation.most).values).cargo[0].filling is not None


def test_what_has_no_key_has_no_relaxation() -> None:
    scene = read_scenario("matrix-liquid-tilt")
    assert relaxations_of(scene, "lift", "c1", {}) == relaxations_of(scene, "apparent gravity", "c1", {}) == []


def test_the_first_share_is_exact_where_the_duration_is_a_power_of_the_limit() -> None:
    duration, elasticity = 2.0, 0.5
    share = first_share(duration, 1.0, elasticity)
    assert duration * (1.0 + share) ** -elasticity == pytest.approx(WITHIN)
    assert first_share(2.0, 1.0, 0.0) == math.inf


@pytest.mark.parametrize(
    ("changes", "constraint", "subject"),
    [
        ({"cargo.1.liquid_height": "105 mm"}, "fill", "c2"),
        ({"cargo.1.max_slosh_height": "60 mm"}, "fill", "c2"),
        ({"cargo.0.at": ["-150 mm", "0 mm"]}, "layout", "c1"),
        ({"cargo.1.at": ["-80 mm", "-60 mm"]}, "layout", "c2"),
        ({"tray.mass": "5.5 kg"}, "payload", "comau-smart-six"),
        (
            {"approach": {"from": [0.0, 3.0, -1.0, 0.0, 0.0, 0.0], "tray": "empty", "acceleration": 5.0}},
            "joint position",
            "joint_2",
        ),
    ],
)
def test_what_the_reader_refuses_can_be_read_with_the_change(
    changes: dict[str, Any], constraint: str, subject: str, changed_scene: Changed
) -> None:
    with pytest.raises(NospillError) as raised:
        changed_scene("matrix-liquid", changes)
    reason = raised.value.reason
    assert reason is not None and (reason.constraint, reason.subject) == (constraint, subject)
    assert reason.excess is not None and reason.excess > 0.0
    assert reason.changes and reason.changes[0].text in str(raised.value)
    scene = read_scenario("matrix-liquid")
    table = changed_table(scene.source, changes)
    for change in reason.changes:
        assert scene_from_table(changed_table(table, change.values), name="changed").cargo


def test_a_limit_of_the_path_parameter_takes_the_place_of_one_in_metres(changed_scene: Callable[..., Scene]) -> None:
    scene = changed_scene("pp-two-cups", {"motion": {"max_jerk": "20 m/s^3"}})
    changed = scene.changed(Change("path jerk", "motion.path_jerk_limit", 39.6, "").values)
    assert changed.motion.path_jerk_limit == 39.6
    assert scene.source["motion"] == {"max_jerk": "20 m/s^3"}
