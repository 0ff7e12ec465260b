"""Colours of the scene and of its charts: those of the figures, and one scale for the use of limits.

The palette is that of Okabe and Ito, which people with any colour blindness tell apart. It is written out again here
because the module of the figures draws in matplotlib, which a viewer must not wait for; a test compares both.
"""

from __future__ import annotations

import numpy as np

BLUE, ORANGE, GREEN, PURPLE = "#0072B2", "#E69F00", "#009E73", "#CC79A7"
SKY, BLACK, GREY, RED = "#56B4E9", "#000000", "#777777", "#D55E00"
PALE = "#DCCB9A"
"""Between the blue and the orange half of the scale; a mixture of those two would be green."""
SERIES = (BLUE, ORANGE, GREEN, PURPLE, BLACK, SKY, GREY)
"""For lines of a chart; vermilion is kept for limits."""
SVG_DASHES = ("", "7 2.4", "2 2", "9 2.4 2 2.4")
"""Dash patterns of the lines of a chart, in the order of the figures' own."""

USE_STOPS: tuple[tuple[float, str], ...] = ((0.0, BLUE), (0.45, SKY), (0.7, PALE), (0.88, ORANGE), (1.0, RED))
"""Use of a limit -> colour, linear between; a broken limit is black."""

_BROKEN_ABOVE = 1.0 + 1e-6


def rgb(colour: str) -> tuple[int, int, int]:
    """Red, green and blue, 0 to 255, of a colour like "#0072B2"."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def use_colours(use: np.ndarray) -> np.ndarray:
    """Colours of uses of a limit.

    Args:
        use: (m,), 1 at the limit; below 0 counts as 0, above 1 is broken, as is what is no number.

    Returns:
        (m, 3) red, green, blue, 0 to 255.
    """
    use = np.asarray(use, dtype=float)
    stops = np.array([stop for stop, _ in USE_STOPS])
    table = np.array([rgb(colour) for _, colour in USE_STOPS], dtype=float)
    inside = np.clip(np.nan_to_num(use, nan=2.0), 0.0, 1.0)
    mixed = np.column_stack([np.interp(inside, stops, table[:, channel]) for channel in range(3)])
    mixed[~(use <= _BROKEN_ABOVE)] = rgb(BLACK)
    return np.rint(mixed).astype(np.uint8)
