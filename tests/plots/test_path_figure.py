"""The figure of the path: ticks, and that it is drawn whatever memory holds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from nospill.plots.evidence import Evidence
from nospill.plots.path_view import path_figure
from nospill.plots.tray_plan import footprint_outline
from nospill.scenario import scene_from_table
from tests.plots.small_plans import CARGO, plan_of, table


def test_a_level_path_has_two_ticks_of_its_height_at_least() -> None:
    level = {"type": "line", "start": [0.8, -0.3, 1.2], "end": [0.8, 0.3, 1.2], "yaw": [0.0, 0.0]}
    found, judgement = plan_of(scene_from_table({**table(CARGO), "path": level}, name="level"), 1.3)
    (axes,) = path_figure(Evidence(found, judgement)).axes
    low, high = axes.get_zlim()  # pyright: ignore[reportAttributeAccessIssue]
    ticks = [tick for tick in axes.get_zticks() if low <= tick <= high]  # pyright: ignore[reportAttributeAccessIssue]
    assert len(ticks) >= 2


def test_the_path_is_drawn_whatever_was_in_memory_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """Objects whose outlines have different numbers of corners, and arrays that hold huge numbers until written."""
    tilting = Evidence(*plan_of(scene_from_table(table(CARGO, tilt="free"), name="x"), 1.0))
    assert len({len(footprint_outline(cargo)) for cargo in tilting.plan.scene.cargo}) > 1
    empty = np.empty

    def with_what_was_there(*arguments: Any, **keywords: Any) -> np.ndarray:
        made = empty(*arguments, **keywords)
        if made.dtype == float:
            made.fill(1.7e308)
        return made

    monkeypatch.setattr(np, "empty", with_what_was_there)
    FigureCanvasAgg(path_figure(tilting)).draw()
