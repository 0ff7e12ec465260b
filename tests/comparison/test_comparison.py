"""The trapezoid and the level tray that a plan is compared with."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import certify
from nospill.comparison import compared, trapezoid_motion
from nospill.comparison.compared import LEVEL, TRAPEZOID
from nospill.paths.path import straight_line
from nospill.plans.plan import Plan
from nospill.plans.summary import failed_summary
from nospill.scenario import read_scenario
from nospill.transcription.trapezoids import PIECES, path_parameter_rates, profile


def test_the_profile_leads_from_rest_to_rest_at_constant_limits() -> None:
    place, speed, acceleration = profile(10 * PIECES)
    for values in (speed, acceleration):
        assert values[[0, -1]] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert (place[0], place[-1]) == (0.0, pytest.approx(1.0))
    assert np.all(np.diff(place) > 0.0)
    third = len(place) // 3
    assert speed[third : 2 * third] == pytest.approx(np.max(speed))
    assert np.max(acceleration) == pytest.approx(-np.min(acceleration))
    jerk = np.diff(acceleration)
    assert np.unique(np.round(jerk / np.max(jerk), 9)).tolist() == [-1.0, 0.0, 1.0]


def test_speed_is_that_along_the_path() -> None:
    path = straight_line((0.0, 0.0, 0.0), (0.6, 0.8, 0.0))
    place, speed, acceleration = profile(27)
    found = path_parameter_rates(path, place, speed, acceleration)
    assert found[:, 0] == pytest.approx(place, abs=1e-9)
    assert np.linalg.norm(path.derivative(found[:, 0])[:, :3], axis=1) * found[:, 1] == pytest.approx(speed, abs=1e-9)
    assert found[:, 2] == pytest.approx(acceleration, abs=1e-9)


@pytest.mark.slow
def test_the_trapezoid_is_certified_and_no_shorter_one_near_it_is() -> None:
    scene = read_scenario("matrix-liquid-tilt")
    found = trapezoid_motion(scene, 2.2)
    assert found is not None
    level = replace(scene, motion=replace(scene.motion, tilt_free=False, end="residual"))
    assert certify(found, level).ok
    assert 2.2 < found.end_time < 2.6


@pytest.mark.slow
def test_what_has_no_certified_motion_is_left_out(
    gentle_plan: Callable[..., Plan], monkeypatch: pytest.MonkeyPatch
) -> None:
    module = sys.modules["nospill.comparison.compared"]  # the package has a function of that name
    asked: list[str] = []
    monkeypatch.setattr(module, "trapezoid_motion", lambda scene, least: None)
    monkeypatch.setattr(module, "_level", lambda found: 6.0)
    plan = gentle_plan("pp-two-cups", 1)
    assert compared(plan, say=asked.append).report.compared == {}
    assert asked == [TRAPEZOID]
    tilting = replace(plan, scene=plan.scene.changed({"motion.tilt": "free"}))
    found = compared(tilting)
    assert found.report.compared == {LEVEL: 6.0}
    assert found.comparison == (
        f"level tray: 6.000 s; this motion is {6.0 - plan.duration:.3f} s "
        f"({100 * (6.0 - plan.duration) / 6.0:.0f} %) sooner",
    )
    assert found.summary()["compared_s"] == {LEVEL: 6.0}
    assert "compared_s" in failed_summary("x", "y")
