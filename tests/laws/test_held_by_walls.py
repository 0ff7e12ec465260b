"""What stands in a holder that is fixed to the tray: its walls keep it from sliding, and it may tip over them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import nospill as ns
from nospill.certification.certificate import judge
from nospill.errors import ScenarioError
from tests.motions import gentle_plan

WALL = 0.04
STANDING = {"lift", "tip", "slosh height", "residual height", "apparent gravity"}


def in_holder(*, fixed: bool, height: float = WALL) -> ns.Scene:
    """The two cups of `pp-two-cups` in one holder, at their places on the tray."""
    before = gentle_plan("pp-two-cups").scene
    holder: dict[str, Any] = {"name": "holder", "shape": "box", "at": [0.0, 0.0], "length": 0.1, "width": 0.24}
    holder |= {"height": height, "mass": 0.3, "fixed": fixed or None}
    cups = [{**entry, "carrier": "holder"} for entry in before.source["cargo"]]
    return before.changed({"fidelity": "full", "planning.slosh_modes": 1, "cargo": [holder, *cups]})


def test_its_walls_take_slip_and_twist_and_leave_lift_tip_and_liquid() -> None:
    rows = judge(gentle_plan("pp-two-cups").trajectory, in_holder(fixed=True)).certificate.rows
    assert {row.constraint for row in rows if row.subject == "left"} == STANDING
    assert not [row for row in rows if row.subject == "holder"]


def test_it_stands_there_as_in_a_rack_of_the_same_walls() -> None:
    """Every row of the cups and of the arm is that of the same holder standing loose, whose own rows are gone."""
    motion = gentle_plan("pp-two-cups").trajectory
    held, loose = (
        {row.id: row for row in judge(motion, in_holder(fixed=fixed)).certificate.rows} for fixed in (True, False)
    )
    assert {key.label for key in loose.keys() - held.keys()} == {
        f"{name} | holder" for name in ("lift", "slip", "tip", "twist")
    }
    assert all(row == loose[key] for key, row in held.items())


def test_the_moment_counts_about_the_top_of_the_wall() -> None:
    """Statics: the centre of pressure of a solid shifts by (h_G - w) f/N, so that tip falls linearly with the wall."""
    scene = gentle_plan("matrix-rigid").scene
    solid = scene.source["cargo"][0]

    def use(wall: float) -> float:
        size = {"length": 0.1, "width": 0.1, "height": wall, "mass": 0.1, "fixed": True}
        holder = {"name": "holder", "shape": "box", "at": solid["at"], **size}
        alone = scene.changed({"cargo": [holder, {**solid, "at": [0.0, 0.0], "carrier": "holder"}]})
        rows = judge(gentle_plan("matrix-rigid").trajectory, alone).certificate.rows
        return next(row.use for row in rows if row.constraint == "tip")

    uses = [use(wall) for wall in (0.01, 0.02, 0.03)]
    assert uses[0] > uses[1] > uses[2] > 0.0
    assert uses[0] - uses[1] == pytest.approx(uses[1] - uses[2], rel=0.02)


def test_swing_goes_on_in_a_fixed_holder_and_not_in_a_loose_one() -> None:
    """No row of a fixed holder reads how its liquids push it, so that motions in a row need no rest."""
    swing = {"cargo.left.initial_swing": {"displacement": [[0.002, 0.0]], "velocity": [[0.0, 0.0]]}}
    begun = in_holder(fixed=True).changed(swing)
    filling = next(item.filling for item in begun.cargo if item.name == "left")
    assert filling is not None and filling.initial_swing is not None
    heights = [
        judge(gentle_plan("pp-two-cups").trajectory, scene).replay.slosh_displacement
        for scene in (begun, in_holder(fixed=True))
    ]
    assert np.abs(heights[0] - heights[1]).max() > 1e-3
    with pytest.raises(ScenarioError, match=r"initial_swing is given to what stands in .*not fixed"):
        in_holder(fixed=False).changed(swing)
