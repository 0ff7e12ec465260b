"""`tolerance.tracking`: what is read, and what is refused in one sentence."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.scenario import read_scenario
from nospill.scene.tracking import Resonance


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
        ({"friction": "1 %"}, r'\[tolerance\.tracking\]: unknown key "friction"; it belongs to \[tolerance\]; allowed'),
        ({"interface": "jtc"}, r"unknown key .*it belongs to \[controller\]; allowed here: delay, lag, resonance"),
        ({"resonance": ["40 Hz", "15 Hz"]}, r'tracking\.resonance = \["40 Hz", "15 Hz"\] is no band; .* as in'),
        ({"resonance": ["15 Hz"]}, r"tracking\.resonance = .*is no band"),
        ({"resonance": "20 Hz", "damping": 0}, r"damping 0 is out of range: it must be at least 0\.005"),
        ({"position": ["1 mrad", 0]}, r"tracking\.position has 2 values where 6 are needed"),
    ],
)
def test_other_bands_are_refused(value: dict, said: str) -> None:
    with pytest.raises(ScenarioError, match=said) as refused:
        read_scenario("matrix-rigid").changed({"tolerance.tracking": value})
    assert "\n" not in str(refused.value)


def test_a_resonance_is_a_band_or_open_above() -> None:
    open_above = read_scenario("matrix-rigid", settings=["tolerance.tracking.resonance=20 Hz"]).tracking
    assert open_above is not None
    assert open_above.resonance is not None
    assert open_above.resonance == Resonance(20.0, np.inf, 0.05)
    assert open_above.resonance.ends == (20.0, 100.0)
    assert open_above.text == "joints elastic at 20 Hz and above"
    band = read_scenario("matrix-rigid").changed(
        {"tolerance.tracking": {"resonance": ["15 Hz", "40 Hz"], "damping": "10 %", "delay": "1 ms"}}
    )
    assert band.tracking is not None
    assert band.tracking.resonance == Resonance(15.0, 40.0, 0.1)
    assert band.tracking.text == "joints up to 1 ms late and elastic at 15 to 40 Hz"


def test_a_position_is_a_sinusoid_up_to_a_bandwidth() -> None:
    found = read_scenario("matrix-rigid", settings=["tolerance.tracking.position=1 mrad"]).tracking
    assert found is not None
    assert found.swing is not None
    assert found.text == "joints off by up to 1 mrad below 5 Hz"
    assert read_scenario("matrix-rigid", settings=["tolerance.tracking.bandwidth=9 Hz"]).tracking is None


def test_an_object_has_no_tracking() -> None:
    with pytest.raises(ScenarioError, match="tracking"):
        read_scenario("matrix-rigid").changed({"cargo.c1.tolerance": {"tracking": {"delay": "1 ms"}}})


def test_liquids_that_are_to_stand_still_at_one_instant_have_no_band() -> None:
    with pytest.raises(ScenarioError, match=r'end = "published" and tolerance\.tracking .* write end = "residual"'):
        read_scenario("matrix-liquid", settings=["tolerance.tracking.delay=1 ms"])
    settings = ["tolerance.tracking.delay=1 ms", "motion.end=residual"]
    assert read_scenario("matrix-liquid", settings=settings).tracking is not None
