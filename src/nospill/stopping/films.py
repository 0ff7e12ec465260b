"""A stop as a film: the plan and its spill-free stop beside the plan and the joints braked, from the same instant.

Both are motions of the joints from rest to rest and are judged as such; the liquids may swing on after them. The path
that is drawn is the plan's.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nospill.core.files import parsed_json
from nospill.drawing.timeline import Film, make_film
from nospill.errors import ModelError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples
from nospill.plans.handover import read_samples
from nospill.plans.loading import load_plan
from nospill.plans.names import STOPS_FILE, STOPS_FOLDER
from nospill.plans.plan import Plan
from nospill.stopping.controller import BrakedJoints, judged_to_rest, scene_to_rest

OWN, BRAKED = "spill-free stop", "joints braked"
"""Titles of the two motions."""
_SAME = 5e-4
"""s; instants that are one, durations that are one plan's."""
_STANDS = 0.05
"""s; how long the arm stands at the end of what is judged."""


def stop_films(folder: Path, at: float, *, rate: float, after_end: float) -> list[Film]:
    """The stop that `nospill stops` has found from an instant, and the joints braked from there: two films of a length.

    Args:
        folder: of the plan, with its table of stops.
        at: s, one of the instants of the table.
        rate: pictures a second.
        after_end: s, beyond the end of the longer one.

    Raises:
        PlanFolderError: the folder is no plan, has no stops or those of another plan, or a file is damaged.
        ScenarioError: no stop begins at that instant, or a liquid of braked joints leaves the range of its model.
    """
    plan = load_plan(folder)
    record = _table(folder, plan)
    stop = _entry(record, at, folder)
    begins = float(stop["t_s"])
    own = _own(plan, folder, stop)
    brake = BrakedJoints(plan.trajectory.motion, begins, np.array(record["deceleration_rad_s2"], dtype=float))
    ends = begins + float(stop["stops_in_s"]), begins + brake.duration
    shown = replace(plan, scene=scene_to_rest(plan.scene, float(record["residual_fraction"])))
    length = max(ends) + after_end
    return [
        _film(shown, motion, end, name, rate, length)
        for motion, end, name in ((own, ends[0], OWN), (brake, ends[1], BRAKED))
    ]


def _film(plan: Plan, motion: JointMotion, end: float, name: str, rate: float, length: float) -> Film:
    scene = replace(plan.scene, name=name)
    try:
        judgement = judged_to_rest(motion, end, plan.trajectory.rate, scene, _STANDS)
    except ModelError as error:
        raise ScenarioError(
            f"{plan.scene.name}, {name}: a liquid moves so far that its linear equations cannot be integrated, and "
            "there is nothing to draw; choose another instant"
        ) from error
    shown = replace(plan, scene=scene, certificate=judgement.certificate, judgement=judgement)
    return replace(make_film(shown, judgement, rate=rate, length=length), end_time=end)


def _own(plan: Plan, folder: Path, stop: dict[str, Any]) -> JointMotion:
    """The plan until the instant and the stop from its file; the plan where what is left of it is the stop."""
    if stop["file"] is None:
        return plan.trajectory.motion
    read = read_samples(EXPORTERS["csv"], folder / STOPS_FOLDER / str(stop["file"]), plan.scene)
    record = plan.trajectory
    rows = round((float(stop["t_s"]) - float(record.t[0])) * record.rate)
    q = np.concatenate([record.joint_position[:rows], read.position])
    return QUINTIC_SPLINE.motion(JointSamples(np.arange(len(q)) / record.rate, q))


def _table(folder: Path, plan: Plan) -> dict[str, Any]:
    path = folder / STOPS_FILE
    if not path.is_file():
        raise PlanFolderError(f"{path}: no such file; find the stops of the plan first: nospill stops {folder}")
    try:
        record = parsed_json(path.read_text(encoding="utf-8-sig"))
        same = abs(float(record["duration_s"]) - plan.duration) <= _SAME
        known = all({"t_s", "stops_in_s", "file"} <= entry.keys() for entry in record["stops"])
        known = known and bool(record["stops"]) and "residual_fraction" in record and "deceleration_rad_s2" in record
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise PlanFolderError(f"{path}: damaged ({error!r}); write it again with nospill stops {folder}") from error
    if not (same and known):
        raise PlanFolderError(f"{path}: not of this plan; write it again with nospill stops {folder}")
    return record


def _entry(record: dict[str, Any], at: float, folder: Path) -> dict[str, Any]:
    nearest = min(record["stops"], key=lambda entry: abs(float(entry["t_s"]) - at))
    if not abs(float(nearest["t_s"]) - at) <= _SAME:
        raise ScenarioError(
            f"--stop {at:g} s: no stop of {folder / STOPS_FILE} begins there; the nearest is from "
            f"{float(nearest['t_s']):g} s"
        )
    return nearest
