"""Warnings about reserves: none kept by the user, or much of a limit kept from the optimiser."""

from __future__ import annotations

from collections.abc import Iterator

from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.warnings.record import Facts, PlanWarning

LARGEST_USUAL_BACKOFF = 0.05
"""Fraction of a limit; where more is kept from the optimiser, motion and judge disagree by as much."""


def no_reserve(facts: Facts) -> Iterator[PlanWarning]:
    """A reserve is set to 0."""
    for cargo in facts.scene.cargo:
        reserves = {"friction_reserve": cargo.friction_reserve, "footprint_reserve": cargo.footprint_reserve}
        if cargo.filling is not None:
            reserves["freeboard_reserve"] = cargo.filling.freeboard_reserve
        for key, value in reserves.items():
            if value == 0.0:
                text = f"{key} is 0: the plan may use all of it, and nothing is left for what the model does not know."
                yield PlanWarning(key.replace("_", " "), cargo.name, text, 0.0, 0.0)


def back_off(facts: Facts) -> Iterator[PlanWarning]:
    """Much of a limit had to be kept from the optimiser until the certificate held.

    Not of residual heights of several modes: the optimiser's row is below them, and back-off makes up for it. Nor of
    heights of second order, of which it has the first.
    """
    to_order = {row.subject for row in facts.judgement.certificate.rows if row.linear_value is not None}
    usual = {ResidualHeight.name} if facts.scene.planned_modes > 1 else set[str]()
    for label, value in facts.backoff.items():
        row = RowId.of(label)
        is_height = row.constraint == SloshHeight.name and any(
            row.subject.split(" at ")[0] == name for name in to_order
        )
        if value > LARGEST_USUAL_BACKOFF and row.constraint not in usual and not is_height:
            text = (
                f"{100 * value:.2g} % of the limit was kept from the optimiser (constraint tightening) until the "
                "exported motion held, which may cost duration; try more planning.intervals or a higher output.rate."
            )
            yield PlanWarning("back-off", label, text, value, LARGEST_USUAL_BACKOFF)
