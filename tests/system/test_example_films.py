"""Films of the bundled examples as they are planned, not of the smooth motions of the other tests."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from nospill.drawing.props import SceneBuilder
from nospill.drawing.timeline import load_films, make_film
from nospill.drawing.views import View
from nospill.plans.plan import Plan
from tests.builders import with_few_speeds
from tests.drawing.test_views import share_of_objects

AS_PLANNED = (
    "matrix-liquid-tilt",
    "matrix-rigid",
    "shelf-to-table",
    "bracket-tray",
    "cups-around-a-column",
    "cups-past-a-column",
)
"""Cups on a tray that tilts, and all examples whose trays are not looked at in tests/drawing/test_views.py."""
RATE = 2.0
"""Pictures a second; the share changes as slowly as the tray tilts."""


@pytest.mark.slow
@pytest.mark.parametrize("name", AS_PLANNED)
def test_objects_fill_a_tenth_of_the_picture_as_planned(name: str, example_plan: Callable[[str], Plan]) -> None:
    plan = example_plan(name)
    film = make_film(plan, plan.evidence, rate=RATE)
    hand = SceneBuilder(film, path=False)
    # in the widest picture, where they are smallest
    assert min(share_of_objects(hand, index, View.TRAY, 16 / 9) for index in range(len(film.t))) >= 0.1


@pytest.mark.slow
def test_a_folder_has_the_film_of_its_plan(example_plan: Callable[[str], Plan], tmp_path: Path) -> None:
    plan = with_few_speeds(example_plan("matrix-liquid"))
    plan.save(tmp_path / "plan")
    film, saved = (
        make_film(plan, plan.evidence, rate=RATE),
        load_films([tmp_path / "plan"], rate=RATE, after_end=0.0)[0],
    )
    assert np.array_equal(saved.t, film.t) and saved.end_time == film.end_time
    assert np.allclose(saved.joint_position, film.joint_position, rtol=0.0, atol=1e-9)
    assert np.allclose(saved.tray_position, film.tray_position, rtol=0.0, atol=1e-9)
