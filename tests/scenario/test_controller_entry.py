"""The table [controller]."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scene_from_table
from nospill.scene.scene import Scene


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
