"""Films of the bundled examples as they are planned, not of the smooth motions of the other tests."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from nospill.drawing.props import SceneBuilder
from nospill.drawing.timeline import load_films
from nospill.drawing.views import View
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.scenario.examples import EXAMPLES
from tests.builders import with_few_speeds
from tests.drawing.test_views import share_of_objects

RATE = 2.0
"""Pictures a second; the share changes as slowly as the tray tilts."""


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_objects_fill_a_tenth_of_the_picture_as_planned(
    name: str, example_plan: Callable[[str], Plan], tmp_path: Path
) -> None:
    plan, folder = with_few_speeds(example_plan(name)), tmp_path / name
    plan.save(folder)
    assert load_plan(folder).trajectory.t[-1] == plan.trajectory.t[-1]
    film = load_films([folder], rate=RATE, after_end=0.0)[0]
    hand = SceneBuilder(film, path=False)
    # in the widest picture, where they are smallest
    assert min(share_of_objects(hand, index, View.TRAY, 16 / 9) for index in range(len(film.t))) >= 0.1
