"""How well two grids of the integration must agree: of a planned motion, and of one that noise has made rough."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nospill.errors import ModelError
from nospill.laws.slosh.integrate import refined, require_converged


def grids(last: float) -> Callable[[int], np.ndarray]:
    """Solutions whose grids differ by `last`, m, from one to the next."""

    def solve(refinement: int) -> np.ndarray:
        return np.full((4 * refinement + 1, 1), last * np.log2(refinement))

    return solve


@pytest.mark.parametrize(("apart", "planned"), [(0.9e-7, True), (1.1e-7, False), (0.9e-5, False)])
def test_a_rough_motion_is_integrated_and_no_planned_one(apart: float, planned: bool) -> None:
    found = refined(grids(apart), displacements=1)
    assert found.error == pytest.approx(apart)
    if planned:
        require_converged(found.error)
    else:
        with pytest.raises(ModelError, match="cannot be integrated along this motion"):
            require_converged(found.error)


def test_what_runs_away_is_refused() -> None:
    with pytest.raises(ModelError, match="leaves its cup"):
        refined(grids(1.1e-5), displacements=1)
