"""Surfaces of small vessels as they are drawn: as high at the wall as they are judged."""

from __future__ import annotations

import numpy as np
import pytest

from nospill.drawing.surfaces import liquid_surface
from nospill.scenario import read_scenario


def test_a_leaning_gravity_lifts_a_vial_as_it_is_judged() -> None:
    vial = read_scenario("vial-rack").cargo[1]
    assert vial.filling is not None
    surface, count = liquid_surface(vial), 2 * vial.filling.modes.count
    lean = np.zeros((1, count + 2))
    lean[0, count] = 0.1
    assert surface.crest(lean)[0] == pytest.approx(abs(0.1 * vial.filling.modes.static_correction[0]), rel=1e-9)
