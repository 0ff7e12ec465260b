"""`tolerance.tracking`: what is read, and what is refused in one sentence."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario


def test_one_value_is_for_every_joint_and_a_list_for_each() -> None:
    scene = read_scenario("matrix-rigid", settings=["tolerance.tracking.delay=3 ms"])
    assert scene.tracking is not None
    assert np.allclose(scene.tracking.delay, 3e-3)
    assert np.allclose(scene.tracking.lag, 0.0)
    each = scene.changed({"tolerance.tracking.lag": ["1 ms", 0, 0, 0, 0, "2 ms"]}).tracking
    assert each is not None
    assert np.allclose(each.latest, [4e-3, 3e-3, 3e-3, 3e-3, 3e-3, 5e-3])


def test_nothing_and_zero_are_no_band() -> None:
    assert read_scenario("matrix-rigid").tracking is None
    assert read_scenario("matrix-rigid", settings=["tolerance.tracking.delay=0"]).tracking is None


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ({"delay": "-1 ms"}, r"\[tolerance\.tracking\]: delay .*-1 ms.*at least 0"),
        ({"delay": "80 ms"}, r"\[tolerance\.tracking\]: delay .*80 ms.*at most 50 ms"),
        ({"lag": ["1 ms", "2 ms"]}, r"tracking\.lag has 2 values where 6 are needed, one for each of joint_1"),
        ({"dealy": "1 ms"}, r"tolerance\.tracking.*dealy.*delay"),
    ],
)
def test_other_bands_are_refused(value: dict, said: str) -> None:
    with pytest.raises(ScenarioError, match=said) as refused:
        read_scenario("matrix-rigid").changed({"tolerance.tracking": value})
    assert "\n" not in str(refused.value)


def test_an_object_has_no_tracking() -> None:
    with pytest.raises(ScenarioError, match="tracking"):
        read_scenario("matrix-rigid").changed({"cargo.c1.tolerance": {"tracking": {"delay": "1 ms"}}})


def test_liquids_that_are_to_stand_still_at_one_instant_have_no_band() -> None:
    with pytest.raises(ScenarioError, match=r'end = "published" and tolerance\.tracking .* write end = "residual"'):
        read_scenario("matrix-liquid", settings=["tolerance.tracking.delay=1 ms"])
    settings = ["tolerance.tracking.delay=1 ms", "motion.end=residual"]
    assert read_scenario("matrix-liquid", settings=settings).tracking is not None
