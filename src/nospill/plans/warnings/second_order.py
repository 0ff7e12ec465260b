"""Warning about what the second order adds to the height of a liquid."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.full_model import full_scene
from nospill.certification.second_order import followed
from nospill.certification.verdict import Row
from nospill.core.units import format_quantity
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.warnings.record import Facts, PlanWarning
from nospill.scene.cargo import Cargo, Filling
from nospill.scene.heights import by_nonlinear_flow, linear_since, unsupported
from nospill.scene.scene import Scene

FIRST_ORDER_CREST = 1.0 / 6.0
"""Part of the radius, or of half the side of a box, up to which what the second order adds is not looked at."""

CREST_ERROR, RESIDUAL_ERROR = 0.03, 0.1
"""Of the flow's crests and of what is left after the end, relative: what is over a limit by less is not called over it
(docs/slosh-model.md)."""

MOST = 1
"""Liquids that are followed, those with the highest crests for their size."""

AFTER = 1.0
"""s at rest after the motion in which a liquid's whole flow is followed."""


def second_order(facts: Facts, full: Judgement) -> Iterator[PlanWarning]:
    """The crests of second order are over a limit that the linear ones keep; of many liquids the highest are asked.

    Args:
        facts: with the rows as they were judged.
        full: the same motion in the full model, whose waves drive the second order.
    """
    rows = {(row.constraint, row.subject): row for row in facts.judgement.certificate.rows}
    for cargo, filling in _highest(facts, rows):
        waves = followed(full_scene(facts.scene), full.replay, cargo.name)
        at = int(np.argmax(waves.crests))
        highest, limit, left = (
            float(waves.crests[at]),
            filling.max_slosh_height,
            waves.highest_after(-1, facts.scene.gravity),
        )
        after = rows.get((ResidualHeight.name, cargo.name))
        allowed = np.inf if after is None else abs(after.limit)
        in_row = rows[SloshHeight.name, cargo.name].linear_value is not None  # of second order itself
        if (highest > (1 + CREST_ERROR) * limit and not in_row) or left > (1 + RESIDUAL_ERROR) * allowed:
            parts = [] if in_row else [f"the crest of second order is {_mm(highest)} at {full.replay.t[at]:.2f} s"]
            parts += [] if in_row else _over(highest, limit)
            if left > (1 + RESIDUAL_ERROR) * allowed:
                order = " to the second order" if in_row else ""
                parts.append(f"after the end it is {_mm(left)}{order} where {_mm(allowed)} are allowed")
            text = (
                f"{', '.join(parts)}; {remedied(facts.scene, cargo, in_row, left > allowed)}, and see by nospill "
                "verify DIR --water what the flow makes of it."
            )
            yield PlanWarning("second order", cargo.name, text, highest, limit)


def remedied(scene: Scene, cargo: Cargo, in_row: bool, left_is_over: bool) -> str:
    """What to plan with: the keys that make limits of these heights, a lower limit where there are none.

    Args:
        scene: of the plan.
        cargo: whose liquid it is.
        in_row: whether its slosh height is judged to the second order already.
        left_is_over: whether what is left after the end is above its limit.
    """
    rules, keys = scene.motion, list[str]()
    if scene.tracking is not None or linear_since(cargo) is not None or (in_row and rules.stop):
        return "plan with a smaller max_slosh_height"
    if scene.fidelity != "full":
        keys.append('fidelity = "full"')
    comes_along = scene.fidelity != "full" and rules.speed_range is None and not _is_stated(scene, "slosh_height")
    if not in_row and not comes_along:
        keys.append('motion.slosh_height = "second order"')
    if left_is_over and not rules.stop:
        flow = by_nonlinear_flow(cargo, "nonlinear")
        keys.append(f'motion.residual_height = "{"nonlinear" if flow else "second order"}"')
    return f"plan with {' and '.join(keys)}"


def _is_stated(scene: Scene, key: str) -> bool:
    return scene.source.get("motion", {}).get(key) is not None


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
