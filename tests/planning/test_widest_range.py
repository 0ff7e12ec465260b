"""Over a range of speeds that is not reached, the motion that holds furthest down it is kept, and says so."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from nospill.planning import widest_range
from nospill.planning.widest_range import holds_from, holds_further, range_reached
from nospill.scene.scene import Scene

_RULES: Any = SimpleNamespace(speed_range=(0.25, 1.0), speeds=(0.8, 0.6, 0.4, 0.25))


def _task(rules: Any = _RULES) -> Any:
    speeds = {("c1", f"{100 * speed:g} %"): speed for speed in (0.8, 0.6, 0.4, 0.25)} | {("c1", ""): 1.0}
    return SimpleNamespace(scene=SimpleNamespace(motion=rules), speeds=speeds)


def _judged(*broken: str, of_object: bool = True) -> Any:
    variants = ("", "80 %", "60 %", "40 %", "25 %")
    rows = [
        SimpleNamespace(subject="c1", variant=variant, ok=variant not in broken, of_object=of_object)
        for variant in variants
    ]
    return SimpleNamespace(variant_rows=rows, certificate=SimpleNamespace(ok=not broken))


def test_it_holds_above_the_greatest_speed_that_breaks_a_limit() -> None:
    assert holds_from(_judged("25 %", "40 %"), _task()) == 0.6
    assert holds_from(_judged("40 %"), _task()) == 0.6  # a quarter of the speed alone is no range
    assert holds_from(_judged(), _task()) == 0.25


def test_nothing_is_known_of_a_motion_broken_at_its_own_speed_or_of_no_range() -> None:
    assert holds_from(_judged(""), _task()) is None
    assert holds_from(_judged("25 %", of_object=False), _task()) is None
    assert holds_from(_judged("25 %"), _task(SimpleNamespace(speed_range=None, speeds=()))) is None


def test_the_motion_that_holds_further_down_is_kept() -> None:
    near, far = _judged("60 %"), _judged("25 %")
    assert holds_further(far, near, _task()) and not holds_further(near, far, _task())
    assert holds_further(near, _judged(""), _task()) and not holds_further(_judged(""), _judged(""), _task())


def test_the_part_that_is_named_has_a_certificate_of_its_own(
    monkeypatch: pytest.MonkeyPatch, changed_scene: Callable[..., Scene]
) -> None:
    asked: list[float] = []

    def judge(_: object, scene: Scene) -> Any:
        assert scene.motion.speed_range is not None and scene.motion.speed_range[1] == 1.0
        asked.append(scene.motion.speed_range[0])
        return SimpleNamespace(certificate=SimpleNamespace(ok=len(asked) > 1))

    monkeypatch.setattr(widest_range, "judge_motion", judge)
    task: Any = SimpleNamespace(
        scene=changed_scene("pp-two-cups", {"motion.speed_range": [0.25, 1.0]}), speeds=_task().speeds
    )
    record: Any = None
    said = range_reached(record, _judged("25 %", "40 %"), task)
    assert len(asked) == 2 and 0.6 < asked[0] < asked[1] < 0.62  # of what was looked at the next one up
    assert f"certified from {100 * asked[1]:.4g} % of its speed on" in said
    assert f"motion.speed_range = [{asked[1]:g}, 1]" in said
    assert range_reached(record, _judged(), task) == ""
