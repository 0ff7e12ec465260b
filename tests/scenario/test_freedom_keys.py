"""The keys about how far the tray may leave its path: what they mean, what is refused, and how they are written."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario, scene_from_table


def rules_of(*settings: str):
    return read_scenario("matrix-liquid", settings=list(settings)).motion


def test_a_path_gives_place_and_yaw_unless_it_says_otherwise() -> None:
    rules = rules_of()
    assert rules.corridor is None and not rules.yaw_free and rules.is_given and not rules.leaves_path
    assert not rules_of("motion.tilt=free").is_given


def test_a_corridor_and_a_free_yaw() -> None:
    scene = read_scenario("matrix-liquid-corridor")
    assert scene.motion.corridor == pytest.approx(0.05) and scene.motion.yaw_free and scene.motion.leaves_path
    np.testing.assert_allclose(scene.path.at([0.0, 1.0])[:, 3], [0.0, np.pi])
    assert scene.motion.on_path() == read_scenario("matrix-liquid-tilt").motion
    assert scene.motion.without_freedom().is_given


def test_the_word_alone_is_a_yaw_of_zero_at_both_ends() -> None:
    scene = read_scenario("matrix-liquid", settings=["path.yaw=free"])
    assert scene.motion.yaw_free
    np.testing.assert_array_equal(scene.path.at([0.0, 0.5, 1.0])[:, 3], 0.0)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        (
            'path.yaw=["0 deg", "free"]',
            r'yaw \["0 deg", "free"\] has the word "free" elsewhere than between two angles',
        ),
        ('path.yaw=["free", "0 deg"]', 'elsewhere than between two angles; give \\["0 deg", "90 deg"\\]'),
        ('path.yaw=["0 deg", "fre", "0 deg"]', 'yaw entry 2 "fre" is not an angle'),
        ("path.yaw=[]", "yaw has no entries; at least 2 are needed"),
        ("path.corridor=-50 mm", 'corridor "-50 mm" is out of range: it must be at least 0.1 mm and at most 2000 mm'),
        ("path.corridor=10 um", "it must be at least 100 um"),
        ("path.corridor=50", 'corridor 50 has no unit.*write "50 mm"'),
    ],
)
def test_refused(setting: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        read_scenario("matrix-liquid", settings=[setting])


def waypoints(**keys: object) -> dict[str, object]:
    s = np.linspace(0.0, 1.0, 60)
    points = np.column_stack([np.full(60, 0.75), s - 0.5, 1.2 + 0.1 * s * (1 - s)]).tolist()
    return {**read_scenario("matrix-liquid").source, "path": {"type": "waypoints", "points": points, **keys}}


def test_the_yaw_of_points_may_be_free_between_its_ends() -> None:
    angles = np.linspace(0.2, 0.8, 60).tolist()
    scene = scene_from_table(waypoints(yaw="free", yaw_at_points=angles), name="points")
    assert scene.motion.yaw_free
    np.testing.assert_allclose(scene.path.at([0.0, 1.0])[:, 3], [0.2, 0.8])
    with pytest.raises(ScenarioError, match="yaw and yaw_at_points: both are given"):
        scene_from_table(waypoints(yaw=[0.1, "free", 0.3], yaw_at_points=angles), name="points")


def test_a_corridor_is_wider_than_the_smoothing_of_its_path() -> None:
    with pytest.raises(ScenarioError, match="corridor is 2 mm wide, no more than the 4 mm of smoothing"):
        scene_from_table(waypoints(corridor="2 mm", smoothing="4 mm"), name="points")


def test_a_corridor_that_widens_along_the_path() -> None:
    widths = ["5 mm", "40 mm", "20 mm"]
    rules = scene_from_table(waypoints(corridor=widths), name="points").motion
    assert rules.corridor == pytest.approx(0.04)
    assert rules.corridor_shares == pytest.approx((0.125, 1.0, 0.5))
    assert rules.on_path().corridor_shares == ()
    for given, message in (
        (["5 mm"], "has 1 widths along the path; give one, or 2 to 50"),
        (["5 mm", "0 mm"], "it must be at least 100 um|it must be at least 0.1 mm"),
        ([50, "5 mm"], "50 has no unit"),
        ([], "has 0 widths"),
    ):
        with pytest.raises(ScenarioError, match=message):
            scene_from_table(waypoints(corridor=given), name="points")
    with pytest.raises(ScenarioError, match="corridor is 5 mm wide, no more than the 6 mm of smoothing"):
        scene_from_table(waypoints(corridor=widths, smoothing="6 mm"), name="points")
