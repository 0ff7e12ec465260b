"""Steps of the integration: halved until two grids agree, as often as a burst between two samples needs it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from nospill.errors import ModelError
from nospill.laws.slosh.integrate import refined


def grids(error: float, order: int) -> Callable[[int], np.ndarray]:
    """Solutions whose difference from the exact one falls with a power of the steps."""
    return lambda refinement: np.full((4 * refinement + 1, 1), error / refinement**order)


@pytest.mark.parametrize(("error", "cuts"), [(1e-8, 2), (1e-6, 4), (1e-4, 16), (5e-3, 32), (0.1, 64)])
def test_steps_are_halved_until_two_grids_agree(error: float, cuts: int) -> None:
    found = refined(grids(error, 4), displacements=1)
    assert found.refinement == cuts and found.error <= 1e-7
    assert len(found.states) == 4 * cuts + 1


def test_what_never_agrees_is_refused() -> None:
    with pytest.raises(ModelError, match=r"error 0\.0\d+ mm with steps cut in 64"):
        refined(grids(1e-3, 1), displacements=1)
