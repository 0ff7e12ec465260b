"""Margins on the bounds of rows: of a limit that is constant the same as so much more back-off."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nospill.laws.constraints.base import RowId
from nospill.transcription.margins_along import Margin, with_margins
from nospill.transcription.problem import build_problem


def test_a_margin_everywhere_is_so_much_more_back_off(smooth_motion: Callable) -> None:
    """At the motion at hand, for cones of any limit and for values between two ends."""
    motion = smooth_motion("mixed-tray", intervals=40, tilt=(0.1, 0.05))
    plain = {"intervals": 40, "nominal_duration": motion.stages.duration}
    problem = build_problem(motion.model, backoff={}, **plain)
    rows = [row for row in dict.fromkeys(place.row for place in problem.places) if row.subject == "cup"]
    kept = 0.1
    tight = with_margins(problem, motion.stages, {row: Margin(np.array([0.0, 1.0]), np.full(2, kept)) for row in rows})
    more = build_problem(motion.model, backoff=dict.fromkeys(rows, kept), **plain)
    variables = problem.encode(motion.stages)
    values = problem.transcription.constraints(variables, problem.parameters)
    other = more.transcription.constraints(variables, more.parameters)
    lower, upper = tight.row_lower, tight.row_upper
    for row, places, _ in problem.places:
        if row not in rows:
            assert np.array_equal(lower[places], problem.transcription.lower[places])
            continue
        if np.all(np.isfinite(upper[places])):
            assert np.allclose(values[places] / upper[places], other[places])
        else:
            slack = other[places] - more.transcription.lower[places]
            assert np.allclose(values[places] - lower[places], slack, atol=1e-9)


def test_a_margin_at_one_place_is_kept_there_alone(smooth_motion: Callable) -> None:
    motion = smooth_motion("mixed-tray", intervals=40, tilt=(0.1, 0.05))
    problem = build_problem(motion.model, intervals=40, nominal_duration=motion.stages.duration, backoff={})
    share = np.linspace(0.0, 1.0, 201)
    row = RowId("slip", "bottle")
    bump = Margin(share, np.where(np.abs(share - 0.5) < 0.01, 0.2, 0.0))
    tight = with_margins(problem, motion.stages, {row: bump}).row_lower
    found = next(place for place in problem.places if place.row == row)
    raised = found.nodes[tight[found.places] > problem.transcription.lower[found.places] + 1e-12]
    assert set(raised.tolist()) <= {19, 20, 21}
    assert 20 in raised


def test_the_margin_around_a_node_is_the_largest_from_half_an_interval_before_to_the_next() -> None:
    margin = Margin(np.array([0.0, 0.25, 0.5, 1.0]), np.array([0.0, 0.4, 0.0, 0.0]))
    assert margin.around(2, 10) == pytest.approx(0.4)
    assert margin.around(7, 10) == 0.0
    assert Margin(np.zeros(1), np.array([0.3])).around(10, 10) == pytest.approx(0.3)
