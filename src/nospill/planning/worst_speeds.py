"""At which speeds of a range a motion breaks its limits most, and which of them a problem is to hold."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import numpy as np

from nospill.certification.verdict import Row
from nospill.scene.variants import VariantId


def peaks(rows: Iterable[Row], speeds: Mapping[VariantId, float]) -> list[Row]:
    """Of every constraint, the row of the worst object at each speed at which the largest use has a local maximum.

    Like objects have theirs at the same speeds: one of them stands for all until a certificate says otherwise.

    Args:
        rows: of variants, at any speeds.
        speeds: of every variant.
    """
    worst: dict[str, list[Row]] = {}
    for row in rows:
        worst.setdefault(row.constraint, []).append(row)
    peak_rows = []
    for of_subject in worst.values():
        at_speed = _worst_at_each(of_subject, speeds)
        ordered = [at_speed[speed] for speed in sorted(at_speed)]
        uses = [0.0, *(row.use for row in ordered), 0.0]
        peak_rows += [
            row for index, row in enumerate(ordered, start=1) if uses[index - 1] < uses[index] >= uses[index + 1]
        ]
    return peak_rows


def evenly(rows: Iterable[Row], speeds: Mapping[VariantId, float], step: float) -> list[Row]:
    """The row with the largest use at each of some speeds v, whose 1/v lie at most about `step` apart.

    At the end of a motion of duration T a mode has the phase omega T / v: over 1/v a residual height is a function of
    limited bandwidth, and steps of pi / (omega T) are half of those that determine it.

    Args:
        rows: of variants, at any speeds.
        speeds: of every variant.
        step: of 1/v.
    """
    at_speed = _worst_at_each(rows, speeds)
    if not at_speed:
        return []
    known = np.array(sorted(at_speed))
    slowness = 1.0 / known
    count = math.ceil((slowness[0] - slowness[-1]) / step) + 1
    wanted = np.linspace(slowness[0], slowness[-1], count)
    nearest = np.unique(np.argmin(np.abs(slowness[:, None] - wanted), axis=0))
    return [at_speed[speed] for speed in known[nearest].tolist()]


def _worst_at_each(rows: Iterable[Row], speeds: Mapping[VariantId, float]) -> dict[float, Row]:
    """By speed, the row with the largest use."""
    worst: dict[float, Row] = {}
    for row in rows:
        speed = speeds[row.subject, row.variant]
        if speed not in worst or row.use > worst[speed].use:
            worst[speed] = row
    return worst


def adjacent_members(speed: float, members: Iterable[VariantId], speeds: Mapping[VariantId, float]) -> list[VariantId]:
    """The slowed members at the speeds next to one, below and above; none where no member is slowed."""
    slowed = [member for member in members if speeds[member] < 1.0]
    next_to = {
        max((speeds[item] for item in slowed if speeds[item] <= speed), default=None),
        min((speeds[item] for item in slowed if speeds[item] >= speed), default=None),
    }
    return [member for member in slowed if speeds[member] in next_to]


def is_far(speed: float, members: Iterable[VariantId], speeds: Mapping[VariantId, float], step: float) -> bool:
    """Whether members are slowed, but to no speed v whose 1/v is within half of `step` of that of `speed`."""
    slowed = [speeds[item] for item in members if speeds[item] < 1.0]
    return bool(slowed) and all(abs(1.0 / speed - 1.0 / own) > 0.5 * step for own in slowed)
