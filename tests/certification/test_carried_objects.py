"""Rows of contact of what stands in a carrier: lift, and tip over walls that are lower than its centre of mass."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from nospill.certification.certificate import judge
from nospill.certification.verdict import Row
from nospill.scenario import scene_from_table
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record

RADIUS, TOP, RESERVE, LENGTH = 0.012, 0.03, 0.05, 0.7


def rows(seat: float, height: float, **changes: Any) -> tuple[dict[tuple[str, str], Row], float]:
    """Rows by constraint and object of a rack with a peg on a level line, and the greatest acceleration, m/s^2."""
    rack = {"name": "rack", "shape": "box", "length": 0.14, "width": 0.1, "height": TOP, "mass": 1.5, "at": [0.0, 0.0]}
    peg = {"name": "peg", "carrier": "rack", "seat_height": seat, "at": [0.03, 0.02], "shape": "cylinder"}
    table = {
        "robot": {"model": "ur10e"},
        "tray": {"size": [0.335, 0.25], "friction": 0.45, "offset": 0.108, "footprint_reserve": RESERVE},
        "cargo": [rack, {**peg, "radius": RADIUS, "height": height, "mass": 0.1, **changes}],
        "path": {"type": "line", "start": [0.7, -LENGTH / 2, 0.4], "end": [0.7, LENGTH / 2, 0.4]},
        "motion": {"tilt": "fixed"},
    }
    scene = scene_from_table(table, name="rack")
    record = smooth_record(scene, joint_path_of(scene), 100, Start(1.0))
    found = judge(record, scene).certificate.rows
    return {(row.constraint, row.subject): row for row in found}, LENGTH * float(np.abs(record.s_acceleration).max())


@pytest.mark.parametrize(("seat", "height"), [(0.005, 0.2), (0.029, 0.2), (0.02, 0.06)])
def test_a_peg_tips_over_the_walls_that_are_lower_than_its_centre(seat: float, height: float) -> None:
    """Statics: a wall of height d takes the horizontal force, so that a (h - d) <= g R of the lever is left."""
    found, most = rows(seat, height)
    lever = height / 2 - (TOP - seat)
    assert lever > 0.0
    tip = found["tip", "peg"]
    assert tip.use == pytest.approx(most * lever / (9.80665 * RADIUS * (1.0 - RESERVE)), rel=5e-3)
    assert found["lift", "peg"].worst_value == pytest.approx(1.0, abs=1e-5)
    assert ("slip", "peg") not in found and ("twist", "peg") not in found and ("slip", "rack") in found


def test_walls_up_to_the_centre_hold_a_peg() -> None:
    found, _ = rows(0.0, 0.05)
    assert found["tip", "peg"].use < 1e-5
    loose, _ = rows(0.0, 0.05, seat_height=0.029)
    assert loose["tip", "peg"].use > 0.3


def test_a_rod_on_the_edge_of_a_rack_is_found_out() -> None:
    found, _ = rows(0.029, 0.2)
    assert not found["tip", "peg"].ok and found["tip", "rack"].ok
