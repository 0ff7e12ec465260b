"""Warning about what the second order adds to the height of a liquid."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from nospill.certification.replay import Replay
from nospill.certification.verdict import Row
from nospill.core.units import format_quantity
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.warnings.record import Facts, PlanWarning
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.heights import unsupported
from nospill.scene.scene import Scene

if TYPE_CHECKING:  # it loads scipy, which a plan does without
    from nospill.potential_flow import BodyRows

FIRST_ORDER_CREST = 1.0 / 6.0
"""Part of the radius, or of half the side of a box, up to which what the second order adds is not looked at."""

CREST_ERROR, RESIDUAL_ERROR = 0.03, 0.1
"""Of the flow's crests and of what is left after the end, relative: what is over a limit by less is not called over it
(docs/slosh-model.md)."""

MOST = 1
"""Liquids that are followed, those with the highest crests for their size; each takes a quarter of a second."""

AFTER = 1.0
"""s at rest after the motion in which the liquid is followed."""


def second_order(facts: Facts) -> Iterator[PlanWarning]:
    """The crests of second order are over a limit that the linear ones keep; of many liquids the highest are asked."""
    rows = {(row.constraint, row.subject): row for row in facts.judgement.certificate.rows}
    for cargo, filling in _highest(facts, rows):
        from nospill.potential_flow import second_order_along

        replay = facts.judgement.replay
        motion = motion_rows(replay, facts.scene, cargo)
        found = second_order_along(cargo, motion, float(replay.t[0]), float(replay.t[-1]), after=AFTER)
        (highest, at), limit, left = found.highest, filling.max_slosh_height, found.after_end
        after = rows.get((ResidualHeight.name, cargo.name))
        allowed = np.inf if after is None else abs(after.limit)
        in_row = rows[SloshHeight.name, cargo.name].linear_value is not None  # of second order itself
        if (highest > (1 + CREST_ERROR) * limit and not in_row) or left > (1 + RESIDUAL_ERROR) * allowed:
            parts = [] if in_row else [f"the crest of second order is {_mm(highest)} at {at:.2f} s"]
            parts += [] if in_row else _over(highest, limit)
            if left > (1 + RESIDUAL_ERROR) * allowed:
                order = " to the second order" if in_row else ""
                parts.append(f"after the end it is {_mm(left)}{order} where {_mm(allowed)} are allowed")
            text = (
                f"{', '.join(parts)}; plan with a smaller max_slosh_height, and see by nospill verify DIR --water "
                "whether it is small enough."
            )
            yield PlanWarning("second order", cargo.name, text, highest, limit)


def _highest(facts: Facts, rows: Mapping[tuple[str, str], Row]) -> list[tuple[Cargo, Filling]]:
    """Liquids that rise above `FIRST_ORDER_CREST`, at most `MOST` of them, in the order of the scene."""
    found = []
    for index, cargo in enumerate(facts.scene.cargo):
        judged, filling = rows.get((SloshHeight.name, cargo.name)), cargo.filling
        if judged is None or filling is None or _to_second_order(judged, rows.get((ResidualHeight.name, cargo.name))):
            continue
        side = float(np.min(cargo.container.section(filling.liquid_height).half_lengths))
        if judged.worst_value > FIRST_ORDER_CREST * side and unsupported(cargo) is None:
            found.append((judged.worst_value / side, index, cargo, filling))
    kept = sorted(found, key=lambda item: item[:2])[-MOST:]
    return [item[2:] for item in sorted(kept, key=lambda item: item[1])]


def _to_second_order(during: Row, after: Row | None) -> bool:
    """Whether the rows on a liquid say already what the second order adds."""
    return during.linear_value is not None and (after is None or after.linear_value is not None)


def _over(highest: float, limit: float) -> list[str]:
    return [f"{_mm(highest - limit)} over the limit"] if highest > limit else []


def _mm(length: float) -> str:
    return format_quantity(length, "length", digits=3)


def motion_rows(replay: Replay, scene: Scene, cargo: Cargo) -> BodyRows:
    """Motion of a container as it was judged, the tray at rest afterwards."""
    up = replay.tray.rotation[-1].T @ np.array([0.0, 0.0, scene.gravity])
    rest = np.concatenate([np.zeros(6), up])
    from nospill.potential_flow import rows_at

    place = np.array([*cargo.position, 0.0])

    def rows(t: np.ndarray) -> np.ndarray:
        body = np.stack([np.interp(t, replay.t, row) for row in replay.body])
        body[:, t > replay.t[-1]] = rest[:, None]
        return rows_at(body, place, cargo.yaw)

    return rows
