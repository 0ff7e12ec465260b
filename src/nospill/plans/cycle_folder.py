"""Reading the folder of a planned cycle: its scenario, a plan folder for every leg, certificate and summary."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from nospill.core.files import parsed_json
from nospill.errors import PlanFolderError
from nospill.plans.cycle import CyclePlan, leg_folder, planned_cycle
from nospill.plans.loading import load_plan
from nospill.plans.names import CERTIFICATE_FILE, CYCLE_FILE, SCENARIO_FILE
from nospill.plans.plan import Plan
from nospill.scenario.cycles import load_cycle
from nospill.scene.cycle import CycleLeg

_SAME = 1e-6
"""s."""


def load_cycle_plan(folder: str | Path) -> CyclePlan:
    """Read the folder of a planned cycle; the verdicts on its motions are those that were saved, `check` judges again.

    Raises:
        PlanFolderError: a file is missing or not what nospill wrote. ScenarioError: a scenario in it is not valid.
    """
    place = Path(folder)
    for name in (SCENARIO_FILE, CERTIFICATE_FILE, CYCLE_FILE):
        if not (place / name).is_file():
            raise PlanFolderError(f"{place}: not the folder of a planned cycle: {name} is missing")
    cycle = load_cycle(place)
    legs = [load_plan(place / leg_folder(index, leg.name)) for index, leg in enumerate(cycle.legs)]
    plan = planned_cycle(replace(cycle, legs=tuple(map(_as_certified, cycle.legs, legs))), legs)
    try:
        summary = parsed_json((place / CYCLE_FILE).read_text(encoding="utf-8-sig"))
        said = [(str(leg["name"]), float(leg["motion_s"]), float(leg["dwell_s"])) for leg in summary["legs"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise PlanFolderError(f"{place}: {CYCLE_FILE} is damaged ({type(error).__name__})") from error
    return plan.with_changes(_changed(plan, said))


def _as_certified(leg: CycleLeg, plan: Plan) -> CycleLeg:
    """The leg with heights of the orders that its folder was read with, `loading.as_certified`."""
    own, found = (scene.source.get("motion", {}) for scene in (leg.scene, plan.scene))
    orders = ("residual_height", "slosh_height")
    changes = {f"motion.{key}": found[key] for key in orders if key in found and found[key] != own.get(key)}
    return replace(leg, scene=leg.scene.changed(changes)) if changes else leg


def _changed(plan: CyclePlan, said: list[tuple[str, float, float]]) -> list[str]:
    """What the summary says otherwise than scenario and trajectories."""
    found = [(leg.name, leg.motion, leg.dwell) for leg in plan.times]
    if [name for name, *_ in found] != [name for name, *_ in said]:
        return [f"{CYCLE_FILE} names other legs than {SCENARIO_FILE}"]
    return [
        f'leg "{name}": {what} is {ours:.4g} s in the files, and {CYCLE_FILE} says {theirs:.4g} s'
        for (name, *one), (_, *other) in zip(found, said, strict=True)
        for what, ours, theirs in zip(("motion", "dwell"), one, other, strict=True)
        if abs(ours - theirs) > _SAME
    ]
