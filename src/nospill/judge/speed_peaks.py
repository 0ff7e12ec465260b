"""At which speeds of a range a motion breaks its limits most."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from nospill.judge.verdict import Row
from nospill.scene.variants import VariantId


def peaks(rows: Iterable[Row], speeds: Mapping[VariantId, float]) -> list[Row]:
    """Of every constraint, the row of the worst object at each speed at which the largest use has a local maximum.

    Like objects have theirs at the same speeds: one of them stands for all until a certificate says otherwise.

    Args:
        rows: of variants, at any speeds.
        speeds: of every variant.
    """
    worst: dict[str, dict[float, Row]] = {}
    for row in rows:
        at_speed, speed = worst.setdefault(row.constraint, {}), speeds[row.subject, row.variant]
        if speed not in at_speed or row.use > at_speed[speed].use:
            at_speed[speed] = row
    found = []
    for at_speed in worst.values():
        ordered = [at_speed[speed] for speed in sorted(at_speed)]
        uses = [0.0, *(row.use for row in ordered), 0.0]
        found += [row for index, row in enumerate(ordered, start=1) if uses[index - 1] < uses[index] >= uses[index + 1]]
    return found
