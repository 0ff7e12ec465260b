"""The margin of a plan, and scenarios that keep a part of their limits on liquids and contacts back.

The margin is the least, over the rows of the certificate about liquids and contacts, of (limit - demand)/limit: one
less the use that it prints. Two kinds of rows are not among them: those of joints, clearance and tray, some of which a
fastest motion fills whatever else it spares, and the displacement of a liquid at the end, an equality that is found to
a tolerance. Neither says how far a spill is.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from nospill.certification.certificate import judge
from nospill.certification.verdict import Row
from nospill.errors import ScenarioError
from nospill.laws.constraints.base import Role
from nospill.laws.constraints.residual_height import EndDisplacement, ResidualHeight
from nospill.planning.varied import Varied
from nospill.plans.approach import with_approach
from nospill.plans.cycle import CyclePlan, planned_cycle
from nospill.plans.plan import Plan, judged_plan
from nospill.scenario.cycles import changed_cycle
from nospill.scene.cycle import Cycle
from nospill.scene.scene import Scene

_RESERVES, _HEIGHT = ("friction_reserve", "footprint_reserve"), "max_slosh_height"


def margin_of(plan: Plan | CyclePlan, kept: Plan | CyclePlan | None = None) -> float | None:
    """The part of its limits on liquids and contacts that a plan leaves at least; None where it has no such limit.

    Args:
        plan: by the limits as stated.
        kept: the same motion by smaller ones. A residual height is a bound, which the judge makes no closer than its
            limit asks for: the lower of two is the one that counts.
    """
    plans, others = _plans(plan), _plans(plan if kept is None else kept)
    uses: list[float] = []
    for one, other in zip(plans, others, strict=True):
        bounds = {row.id: row.worst_value for row in other.certificate.rows if row.constraint == ResidualHeight.name}
        uses += [
            min(row.use, bounds.get(row.id, np.inf) / row.limit) if row.constraint == ResidualHeight.name else row.use
            for row in one.certificate.rows
            if _counts(row)
        ]
    return 1.0 - max(uses) if uses else None


def _plans(plan: Plan | CyclePlan) -> tuple[Plan, ...]:
    return plan.legs if isinstance(plan, CyclePlan) else (plan,)


def _counts(row: Row) -> bool:
    known = row.known
    return known is not None and known.role in (Role.LIQUID, Role.CONTACT) and known.name != EndDisplacement.name


def reserving(task: Scene | Cycle, reserve: float) -> dict[str, Any]:
    """Changes by which a part of every limit on liquids and contacts is kept back, beside what the scenario keeps.

    Heights, during the motion and after it, friction (slip and twist) and footprints (tip) are smaller by that part.
    Lift, trough and apparent gravity have no key; `margin_of` sees what they leave.

    Args:
        task: a motion or a cycle.
        reserve: the part, 0 to below 1.
    """
    changes: dict[str, Any] = {}
    for item in {item.name: item for scene in Varied(task).scenes for item in scene.cargo}.values():
        if not (item.fixed or item.carrier):  # what stands in a carrier has the friction of that
            changes |= {
                f"cargo.{item.name}.{key}": 1.0 - (1.0 - reserve) * (1.0 - getattr(item, key)) for key in _RESERVES
            }
        if item.filling is not None and not item.filling.lid:
            changes[f"cargo.{item.name}.{_HEIGHT}"] = (1.0 - reserve) * item.filling.max_slosh_height
    return changes


def by_own_limits(plan: Plan | CyclePlan, task: Scene | Cycle) -> Plan | CyclePlan:
    """A plan that keeps a reserve, judged by the limits as a task states them.

    Args:
        plan: of the task with the changes of `reserving`.
        task: without them.
    """
    stated = {entry["name"]: entry for entry in Varied(task).table["cargo"]}
    own = {key: stated[key.split(".")[1]].get(key.split(".")[2]) for key in reserving(task, 0.0)}
    if not isinstance(plan, CyclePlan):
        return _judged(plan, own)
    legs = []
    for leg in plan.legs:
        names = {item.name for item in leg.scene.cargo}
        legs.append(_judged(leg, {key: value for key, value in own.items() if key.split(".")[1] in names}))
    return planned_cycle(changed_cycle(plan.cycle, own), legs)


def _judged(plan: Plan, own: dict[str, Any]) -> Plan:
    scene = plan.scene.changed(own)
    found = judged_plan(scene, plan.trajectory, judge(plan.trajectory, scene), plan.report)
    return found if plan.approach is None else with_approach(replace(found, approach=None))


def require_margin(base: Varied) -> None:
    """Raise ScenarioError where nothing on the tray has a limit that could be kept from."""
    if not reserving(base.task, 0.0):
        raise ScenarioError(
            f"{base.name}: no liquid is open and nothing stands loose, so that there is no margin; leave the time out "
            "for the shortest motion"
        )
