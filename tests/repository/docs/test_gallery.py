"""The motions that the gallery shows: planned by the build, not the smooth ones of the other tests."""

from __future__ import annotations

from pathlib import Path

import pytest

from nospill.drawing.props import Stagehand
from nospill.drawing.timeline import load_films
from nospill.drawing.views import View
from nospill.scenario.examples import EXAMPLES
from tests.drawing.test_views import share_of_objects

CACHE = Path(__file__).parents[3] / "docs" / "_build" / "cache"
RATE = 2.0
"""Pictures a second; the share changes as slowly as the tray tilts."""


@pytest.mark.slow
@pytest.mark.parametrize("name", EXAMPLES)
def test_objects_fill_a_tenth_of_the_picture_as_planned(name: str) -> None:
    folders = [place / "plan" for place in CACHE.glob(f"plan-{name}-{'[0-9a-f]' * 16}")]
    if not folders:
        pytest.skip("planned by make docs")
    film = load_films(folders[:1], rate=RATE, after_end=0.0)[0]
    hand = Stagehand(film, path=False)
    # in the widest picture, where they are smallest
    assert min(share_of_objects(hand, index, View.TRAY, 16 / 9) for index in range(len(film.t))) >= 0.1
