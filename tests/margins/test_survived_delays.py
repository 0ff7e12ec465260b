"""The delay that a plan survives, against the arms of the study of margins: another replay, on another grid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from nospill.certification.survival import Looked, delay_fault, survived
from nospill.certification.tracked_rows import Followed
from nospill.certification.verdict import limit_use
from nospill.laws.constraints.base import Role, RowId
from nospill.margins.laws import object_margins, simulate_arms
from nospill.plans.plan import Plan
from nospill.scene.controller import Controller
from nospill.scene.tracking import Arm


@pytest.mark.slow
@pytest.mark.parametrize("name", ["matrix-rigid", "shelf-to-table"])
def test_the_first_of_all_arms_fails_within_a_tenth_of_the_delay(
    name: str, example_plan: Callable[[str], Plan]
) -> None:
    """Every joint late or on time, in all combinations; what the plan says fails first is a contact in both."""
    plan = example_plan(name)
    followed = Followed.of(plan.trajectory, plan.scene, plan.certificate.rows)
    found = survived(Looked.at(followed), delay_fault(followed))
    assert found.size is not None
    subject = RowId.of(found.first).subject
    (cargo,) = (item for item in plan.scene.cargo if item.name == subject)
    scene = replace(plan.scene, cargo=(replace(cargo, friction_reserve=0.0, footprint_reserve=0.0),))
    shares = [np.array(share) for share in product((0.0, 1.0), repeat=followed.joints)][1:-1]

    def worst(delay: float) -> float:
        arms = [Arm.late(Controller(delay * share, np.zeros_like(share))) for share in shares]
        uses = []
        for motion in simulate_arms(plan.trajectory, scene, arms, after=delay):
            (own,) = object_margins(scene, [list(scene.cargo)], motion)
            figures = zip(own.constraints, own.limit[0], own.margin[0], strict=True)
            uses += [
                float(limit_use(item, limit, margin)) for item, limit, margin in figures if item.role is Role.CONTACT
            ]
        return max(uses)

    assert worst(0.9 * found.size) < 1.0 < worst(1.1 * found.size)
