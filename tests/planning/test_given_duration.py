"""Motions of a given duration: exactly so long, certified, and gentler the longer they take."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.errors import NoSolutionError
from nospill.planning.planner import plan
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan

pytestmark = pytest.mark.slow


def mean_square_jerk(found: Plan) -> float:
    """Of the path parameter, by third differences of the samples, 1/s^6."""
    period = 1.0 / found.trajectory.rate
    return float(np.mean((np.diff(found.trajectory.s, 3) / period**3) ** 2))


def test_the_gentlest_motion_of_a_given_duration(changed_scene, example_plan, tmp_path) -> None:
    fastest = example_plan("matrix-liquid")
    jerks = []
    for factor in (1.0, 1.1, 1.5):
        found = plan(changed_scene("matrix-liquid", {"motion.duration": factor * fastest.duration}))
        assert found.certificate.ok
        assert found.duration == pytest.approx(factor * fastest.duration, rel=1e-7)
        jerks.append(mean_square_jerk(found))
    assert jerks[0] > 1.5 * jerks[1] > 5 * jerks[2]
    # The least of all from rest to rest is that of the quintic, 720 / T^6; liquids at rest at the end cost more.
    assert 1.0 < jerks[2] * found.duration**6 / 720 < 1.1
    found.save(tmp_path / "out")
    assert load_plan(tmp_path / "out").scene.motion.duration == pytest.approx(1.5 * fastest.duration)


def test_a_tray_that_tilts(changed_scene) -> None:
    found = plan(changed_scene("matrix-liquid-tilt", {"motion.duration": "2 s", "planning.slosh_modes": 1}))
    assert found.certificate.ok and found.duration == pytest.approx(2.0, rel=1e-7)


def test_a_duration_that_is_too_short_is_reported_with_the_least_that_suffices(changed_scene) -> None:
    coarse = {"planning.intervals": 20, "planning.max_iterations": 50}
    with pytest.raises(NoSolutionError, match=r"none within duration 1 s; the fastest found takes 1\.\d+ s") as caught:
        plan(changed_scene("pp-two-cups", {"motion.duration": 1.0, **coarse}))
    assert caught.value.reason is not None
    keys = {change.place: change.value for change in caught.value.reason.changes}
    assert keys["motion.duration"] == pytest.approx(1.9, rel=0.1)
