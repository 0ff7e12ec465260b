"""Crests along motions: what the flow says of itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nospill.potential_flow import Crests, crests_along
from nospill.scene.heights import unsupported
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.scene.swing import Swing
from nospill.simulation.cup_file import cup_from_table
from tests.waters import STILL, cup, tub


def _still(t: np.ndarray) -> np.ndarray:
    return np.tile(STILL[:, None], (1, len(t)))


def _pushed(size: float, *, length: float = 0.4):
    """Rows of a move sideways from rest to rest, with a largest acceleration of `size` m/s^2."""

    def rows(t: np.ndarray) -> np.ndarray:
        body = _still(t)
        body[6] = size * np.sin(2 * np.pi * t / length) * ((t >= 0.0) & (t < length))
        return body

    return rows


def test_a_liquid_that_stands_stays_level() -> None:
    found = crests_along(cup(), _still, 0.0, 0.1, after=0.1)
    assert not found.linear.any() and not found.second.any() and not found.full.any()
    assert found.doubt is None and found.spread == 0.0


def test_a_gentle_motion_is_trusted_and_crests_over_the_linear_height() -> None:
    found = crests_along(cup(), _pushed(1.0), 0.0, 0.4, after=0.4)
    assert found.doubt is None and found.breaks_at is None
    linear, second, full = (found.highest(item)[0] for item in (found.linear, found.second, found.full))
    assert linear < full and linear < second
    assert second == pytest.approx(full, rel=0.03)
    assert found.after_end(found.full) == pytest.approx(np.max(found.full[found.t >= 0.4]))


def test_a_violent_motion_is_doubted_not_computed_on() -> None:
    found = crests_along(cup(), _pushed(14.0), 0.0, 0.4, after=0.4)
    assert found.doubt is not None
    assert len(found.full) < len(found.t) and found.breaks_at is not None
    assert found.doubt == f"the flow's numbers break down at {found.breaks_at:.2f} s"
    assert found.after_end(found.full) is None
    assert np.all(np.isfinite(found.second))


def test_a_steep_surface_is_doubted() -> None:
    found = crests_along(cup(), _pushed(1.0), 0.0, 0.4, after=0.1)
    steep = replace(found, steepness=np.where(found.t[: len(found.full)] > 0.3, 1.2, found.steepness))
    assert steep.doubt == "from 0.30 s on the surface is steeper than 45 deg, where standing waves break"


def test_a_crest_that_depends_on_the_number_of_modes_is_doubted() -> None:
    found = crests_along(cup(), _pushed(1.0), 0.0, 0.4, after=0.1)
    fewer: Crests = replace(found, coarse=0.9 * found.full)
    assert fewer.doubt == "with fewer modes the highest crest is 10 % off"


def test_the_swing_at_the_start_goes_on() -> None:
    swing = Swing(displacement=((2e-3, -1e-3),), velocity=((0.01, 0.02),))
    cargo = cup()
    assert cargo.filling is not None
    begun = replace(cargo, filling=replace(cargo.filling, initial_swing=swing))
    found = crests_along(begun, _still, 0.0, 0.2, after=0.5)
    first = cargo.filling.oscillators[0]
    assert found.linear[0] == pytest.approx(first.surface_gain * np.hypot(2e-3, 1e-3), rel=1e-3)
    later = np.exp(-first.damping * first.frequency * found.t) * first.surface_gain
    turn = first.frequency * found.t
    expected = later[:, None] * (
        np.outer(np.cos(turn), [2e-3, -1e-3]) + np.outer(np.sin(turn), [0.01, 0.02]) / first.frequency
    )
    assert found.linear == pytest.approx(np.linalg.norm(expected, axis=1), abs=3e-5)


def test_a_lean_that_stays_leaves_the_plane_level_surface() -> None:
    """Linear in the slope; the damping of the wave that the start leaves is made large."""
    lean = 0.05
    row = np.array([0.0] * 6 + [STANDARD_GRAVITY * np.sin(lean), 0.0, STANDARD_GRAVITY * np.cos(lean)])
    found = crests_along(cup(damping=0.9), lambda t: np.tile(row[:, None], (1, len(t))), 0.0, 3.0, after=0.1)
    assert found.linear[-1] == pytest.approx(0.035 * np.tan(lean), rel=1e-3)
    assert found.full[-1] == pytest.approx(0.035 * np.tan(lean), rel=5e-3)


def test_shapes_without_a_flow_are_named() -> None:
    bowl = {"shape": "bowl", "radius": 0.07, "bottom_radius": 0.03, "height": 0.06, "liquid_height": 0.03}
    cargo = cup_from_table({**bowl, "liquid": "water", "mass": "0.3 kg", "max_slosh_height": 0.01}, slosh_modes=2)
    assert unsupported(cargo) == "the flow is known in upright cylinders and boxes only"
    assert unsupported(cup()) is None and unsupported(tub()) is None
    assert unsupported(cup(contact_line="free")) == "the flow leaves surface tension out, and a contact line is stated"
