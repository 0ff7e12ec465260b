"""The table [controller]."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene
from tests.franka_plans import drawn_tables


def scene_with(**controller: Any) -> Scene:
    return scene_from_table({**read_scenario("matrix-liquid").source, "controller": controller}, name="own")


def test_one_value_is_for_all_joints() -> None:
    found = scene_with(delay="8 ms", lag=[0.01] * 5 + ["15 ms"]).controller
    assert found is not None
    assert found.delay == pytest.approx(np.full(6, 0.008))
    assert found.lag[[0, 5]] == pytest.approx([0.01, 0.015])
    assert found.compensate
    assert found.tracking_tolerance is None


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        (
            {"delay": ["1 ms", "2 ms"]},
            r"\[controller\].*delay has 2 values where 6 are needed, one for each of joint_1",
        ),
        ({"lag": "-1 ms"}, r"\[controller\]: lag .* is out of range"),
        ({"lag": "2 s"}, r"\[controller\]: lag .* is out of range"),
        ({"compensate": "no"}, r"\[controller\]: compensate \"no\" is neither true nor false"),
        ({"lags": "1 ms"}, "lags"),
        ({"tracking_tolerance": "5 mm"}, r"\[controller\]: tracking_tolerance \"5 mm\" is a length, not an angle"),
    ],
)
def test_wrong_values_are_refused(controller: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        scene_with(**controller)
    assert "\n" not in str(caught.value)


def arm(**controller: Any) -> Scene:
    """A Franka Research 3 with a `[controller]`."""
    return scene_from_table({**next(drawn_tables()), "controller": controller}, name="own")


def test_an_interface_brings_its_rate_and_its_limits() -> None:
    scene = arm(interface="fci", points=200)
    assert scene.controller is not None and scene.controller.interface is not None
    assert scene.controller.interface.name == "fci" and scene.controller.points == 200
    assert not scene.controller.is_late
    assert scene.output_rate == scene.controller.update_rate == 1000.0
    assert scene.motion.max_speed == 3.0
    assert scene.robot.max_acceleration == pytest.approx(np.full(7, 9.999))


def test_a_rate_of_the_output_that_is_stated_stays_where_the_interface_reads_as_many() -> None:
    table = {**next(drawn_tables()), "controller": {"interface": "fci"}, "output": {"rate": "250 Hz"}}
    assert scene_from_table(table, name="own").output_rate == 250.0
    slow = table | {"controller": {"interface": "jtc", "update_rate": "100 Hz"}}
    with pytest.raises(ScenarioError, match=r"\[output\]: rate is 250 Hz; jtc reads 100 positions a second"):
        scene_from_table(slow, name="own")


@pytest.mark.parametrize(
    ("controller", "message"),
    [
        (
            {"interface": "ur-servoj"},
            r'\[controller\]: interface is "ur-servoj", which franka-fr3 lacks; it has fci, jtc',
        ),
        ({"interface": "fci", "update_rate": "500 Hz"}, r"\[controller\]: update_rate is 500 Hz; fci has 1000 Hz"),
        ({"update_rate": "500 Hz"}, r"\[controller\]: update_rate is stated without an interface"),
        ({"interface": 3}, r"\[controller\]: interface"),
        ({"points": 1}, r"\[controller\]: points 1 is out of range"),
    ],
)
def test_interfaces_that_the_arm_lacks_are_refused(controller: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        arm(**controller)
    assert "\n" not in str(caught.value)


def test_a_scale_of_the_speed_scales_the_limits_near_the_ends() -> None:
    whole, half = (
        scene_from_table(
            {**next(drawn_tables()), "robot": {"model": "franka-fr3", "limits": limits}}, name="own"
        ).robot.braking
        for limits in ({}, {"speed_scale": 0.5})
    )
    assert whole is not None and half is not None
    assert half.deceleration == pytest.approx(whole.deceleration / 4.0)
    assert half.offset == pytest.approx(whole.offset / 2.0)
