"""What the search of a stop leaves out, and the margin with which a height of second order begins to bind."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nospill.planning import wave_margins
from nospill.stopping import solving
from nospill.transcription.margins_along import Margin

SHARES = wave_margins._SHARES


def _stop(duration: float) -> Any:
    return SimpleNamespace(stop=SimpleNamespace(duration=duration), stays=True)


def test_an_answer_that_takes_too_long_is_not_judged(monkeypatch: pytest.MonkeyPatch) -> None:
    def judged(*_: object) -> None:
        raise AssertionError("judged")

    monkeypatch.setattr(solving, "_exported", judged)
    answer: Any = SimpleNamespace(converged=True, stages=SimpleNamespace(duration=0.5))
    nothing: Any = SimpleNamespace(scene=None)
    assert solving._certified(nothing, nothing, nothing, answer, most=0.49, splice=None) is None
    with pytest.raises(AssertionError, match="judged"):
        solving._certified(nothing, nothing, nothing, answer, most=0.51, splice=None)


@pytest.mark.parametrize(
    ("afresh_above", "following", "expected"),
    [
        (0.0, 0.3, ["afar 0.99", "following 0.40"]),  # the stop before is followed as long as it may be sooner
        (0.0, None, ["afar 0.99", "following 0.40"]),
        (math.inf, 0.5, ["following 1.00"]),
        (math.inf, None, ["following 1.00", "afar 0.99"]),
        (0.45, 0.5, ["following 1.00", "afar 0.50"]),  # and from afar as long as that may be sooner
    ],
)
def test_each_way_of_search_is_followed_as_long_as_it_may_be_sooner(
    monkeypatch: pytest.MonkeyPatch, afresh_above: float, following: float | None, expected: list[str]
) -> None:
    asked: list[str] = []

    def from_afar(_: object, __: object, ___: object, ____: float, most: float, *splice: object) -> Any:
        asked.append(f"afar {most:.2f}")
        return _stop(0.4)

    def follow(_: object, __: object, ___: object, most: float, *splice: object) -> Any:
        asked.append(f"following {most:.2f}")
        return None if following is None else _stop(following)

    monkeypatch.setattr(solving, "found_from_afar", from_afar)
    monkeypatch.setattr(solving, "_following", follow)
    monkeypatch.setattr(solving, "stopping_scene", lambda *_: None)
    monkeypatch.setattr(solving, "bound_of", lambda *_: None)
    monkeypatch.setattr(solving, "replace", lambda stop, **_: stop)
    plan: Any = SimpleNamespace(duration=1.5, scene=None)
    state: Any = SimpleNamespace(t=0.5)
    anything: Any = None
    stop, _ = solving.stop_from(plan, state, anything, anything or _stop(0.6), afresh_above=afresh_above)
    assert asked == expected
    assert stop.duration == (following if expected[-1].startswith("following") and following else 0.4)


def test_a_margin_that_does_not_bind_where_a_height_is_too_high_begins_with_what_binds() -> None:
    share = np.linspace(0.0, 1.0, SHARES + 1)
    margin = Margin(share, np.full(SHARES + 1, 0.2))
    part = np.array([5, 10, 20, 30])
    trace: Any = SimpleNamespace(
        linear=np.array([7.2, 7.2, 8.0, 3.0]), limit=np.full(4, 10.0), use=np.array([1.02, 0.98, 1.02, 1.02])
    )
    found = wave_margins._binding(0.0, margin, trace, part)
    assert found[5] == pytest.approx(0.28)  # 0.8 of the limit is left to it, and it is at 0.72
    assert np.all(
        found[[0, 10, 20, 30]] == 0.0
    )  # nothing is too high, it binds already, or waves from earlier drive it
