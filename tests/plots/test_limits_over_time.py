"""Limits over time: their colours, and that the command draws them."""

from __future__ import annotations

import numpy as np

from nospill.plots import FIRST_FIGURES, figures
from nospill.plots.limiting import USE_COLOURS


def test_colours_of_use_grow_darker() -> None:
    """So that they are told apart on grey paper."""
    red, green, blue, _ = USE_COLOURS(np.linspace(0.0, 1.0, 50)).T
    grey = 0.299 * red + 0.587 * green + 0.114 * blue
    assert np.all(np.diff(grey) < 0)
    assert np.ptp(grey) > 0.5
    assert USE_COLOURS(2.0) == (0.0, 0.0, 0.0, 1.0)


def test_first_figures_are_figures() -> None:
    assert set(FIRST_FIGURES) < set(figures.FIGURES)
