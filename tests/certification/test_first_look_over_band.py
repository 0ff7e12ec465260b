"""The first look at a band of late arms, with which rounds of planning end that break a row."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from nospill.certification import tracking_band
from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.tracking_band import broken_or_band_of
from nospill.errors import ModelError
from nospill.planning import shortening
from nospill.planning.candidate import Candidate
from nospill.planning.log import Log
from nospill.planning.refinement import Judged
from nospill.planning.shortening import _with_whole_verdict
from nospill.scene.scene import Scene
from tests.motions import SmoothMotion

LATE = {"delay": "3 ms", "lag": "2 ms"}


@pytest.fixture(scope="module")
def motion(smooth_motion: Callable) -> SmoothMotion:
    found = smooth_motion("mixed-tray", cargo=2, stretch=0.6, tilt=(0.1, 0.05))
    return replace(found, scene=found.scene.changed({"motion.slosh_height": "linear"}))


@pytest.fixture(scope="module")
def scene(motion: SmoothMotion) -> Scene:
    return motion.scene.changed({"tolerance.tracking": LATE})


@pytest.fixture(scope="module")
def whole(motion: SmoothMotion, scene: Scene) -> Judgement:
    return judge_motion(motion.trajectory, scene)


@pytest.fixture
def looked_at(motion: SmoothMotion, scene: Scene, monkeypatch: pytest.MonkeyPatch) -> Callable[[float], Judgement]:
    """The motion looked at first where a use from a given one on counts as broken."""

    def look(broken: float) -> Judgement:
        monkeypatch.setattr(tracking_band, "_BROKEN", broken)
        return judge_motion(motion.trajectory, scene, over_band=broken_or_band_of)

    return look


def test_half_of_the_rate_finds_what_the_whole_does(
    whole: Judgement, looked_at: Callable[[float], Judgement], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within less than what a use has to be over its limit to be broken, and never more than the band."""
    first = looked_at(0.0).band
    monkeypatch.setattr(tracking_band, "_FIRST_LOOK", 1000.0)
    fast, band = looked_at(0.0).band, whole.band
    assert first is not None
    assert fast is not None
    assert band is not None
    assert max(float(np.max(added)) for added in fast.added.values()) > 0.05
    for row, use in fast.use.items():
        assert first.use[row] == pytest.approx(use, abs=3e-3)
        assert use <= band.use[row]
    assert {row.variant for row in first.rows} == {"joints up to 3 ms late with a lag of up to 2 ms"}


def test_a_motion_that_it_does_not_show_broken_is_judged_as_ever(
    whole: Judgement, looked_at: Callable[[float], Judgement]
) -> None:
    found = looked_at(np.inf)
    assert found.certificate == whole.certificate
    assert found.band is not None
    assert whole.band is not None
    assert found.band.use == whole.band.use


def test_planning_ends_with_the_whole_verdict(
    motion: SmoothMotion, scene: Scene, whole: Judgement, looked_at: Callable[[float], Judgement]
) -> None:
    """Where rounds run out with a motion of which a first look was enough."""
    first = looked_at(0.0)
    broken = replace(first, certificate=replace(first.certificate, ok=False))
    candidate = SimpleNamespace(active=SimpleNamespace(task=SimpleNamespace(scene=scene)))
    judged = _with_whole_verdict(Judged(cast(Candidate, candidate), motion.trajectory, broken), Log(None, 60.0))
    assert judged.judgement.certificate == whole.certificate


def test_what_a_first_look_broke_stands_where_an_arm_has_no_answer(
    motion: SmoothMotion, scene: Scene, looked_at: Callable[[float], Judgement], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A plan ends uncertified then, and not in an error."""

    def no_answer(*_: object, **__: object) -> Judgement:
        raise ModelError("the liquid leaves its cup")

    first = looked_at(0.0)
    broken = replace(first, certificate=replace(first.certificate, ok=False))
    candidate = SimpleNamespace(active=SimpleNamespace(task=SimpleNamespace(scene=scene)))
    judged = Judged(cast(Candidate, candidate), motion.trajectory, broken)
    monkeypatch.setattr(shortening, "judge_motion", no_answer)
    assert _with_whole_verdict(judged, Log(None, 60.0)) is judged
