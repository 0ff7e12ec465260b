"""Warnings about the nonlinear flow that judges heights of liquids, where it does."""

from __future__ import annotations

from collections.abc import Iterator

from nospill.certification.by_flow import broken_flows, doubted_flows
from nospill.core.units import format_quantity
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.plans.warnings.record import Facts, PlanWarning


def _mm(length: float) -> str:
    return format_quantity(length, "length", digits=3)


def flow(facts: Facts) -> Iterator[PlanWarning]:
    """The nonlinear flow that judges a height breaks down: the row is over its limit by no height of a liquid."""
    rules = facts.scene.motion
    orders = {
        SloshHeight.name: ("slosh_height", rules.slosh_height),
        ResidualHeight.name: ("residual_height", rules.residual_height),
    }
    over: dict[str, list[str]] = {}
    for row in facts.judgement.certificate.rows:
        key, order = orders.get(row.constraint, ("", "linear"))
        if not row.ok and order == "nonlinear":
            over.setdefault(row.subject, []).append(f'motion.{key} = "second order"')
    if not over:
        return
    for name, (breaks_at, height) in broken_flows(facts.scene, facts.judgement.replay).items():
        if name in over:
            text = (
                f"the flow of the liquid breaks down at {breaks_at:.2f} s, so its height from there on is not known "
                f"and counts as {_mm(height)}; try a smaller max_slosh_height, a longer motion.duration or "
                f"{' and '.join(over[name])}."
            )
            yield PlanWarning("flow", name, text, breaks_at)


def flow_in_doubt(facts: Facts) -> Iterator[PlanWarning]:
    """The nonlinear flow that judges a height goes through, and is not to be trusted, as `verify --water` says."""
    height = "height" if facts.scene.motion.slosh_height == "nonlinear" else "height after the end"
    for name, doubt in doubted_flows(facts.scene, facts.judgement.replay).items():
        text = (
            f"{doubt}; the nonlinear flow that judges its {height} is no verdict there, see nospill verify DIR "
            "--water, and try a smaller max_slosh_height or a longer motion.duration."
        )
        yield PlanWarning("flow in doubt", name, text)
