"""A stop beside the controller's own from the same instant, as films: the plan until then, the stop, what follows."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nospill.certification.certificate import judge_joints
from nospill.core.units import as_written, quantity
from nospill.drawing.timeline import Film, make_film
from nospill.errors import ModelError, PlanFolderError, ScenarioError
from nospill.export import EXPORTERS
from nospill.motion.interpolation import QUINTIC_SPLINE, JointMotion, JointSamples
from nospill.plans.loading import load_plan
from nospill.plans.names import STOPS_FILE, STOPS_FOLDER
from nospill.plans.plan import Plan
from nospill.stopping.controller import BrakedJoints, SlowedClock, record_to_rest

KINDS = {"joints": "each joint brakes by itself", "path": "time is scaled to zero along the path"}
"""The controller's own stops, by the names that they have in stops.json."""

_STANDS = 0.1
"""s, for which the arm is on record after it stands."""
_ON_GRID = 1e-6
"""s, by which an instant may be off."""


def films_of_stop(folder: Path, at: str, kind: str, *, rate: float, after_end: float) -> list[Film]:
    """The spill-free stop that begins at an instant of a plan, and the controller's own from there, on one clock.

    Args:
        folder: of a plan whose stops have been found.
        at: the instant, as text with a unit or in s.
        kind: the controller's stop, one of `KINDS`.
        rate: pictures per second.
        after_end: s that are seen after the later of both ends.

    Raises:
        PlanFolderError: the folder is no plan, its stops have not been found, or their files are damaged.
        ScenarioError: no stop begins at that instant, or there is no such kind.
        ModelError: the liquids of one of the motions cannot be integrated.
    """
    if kind not in KINDS:
        said = " or ".join(f"{name} ({does})" for name, does in KINDS.items())
        raise ScenarioError(f"--beside {as_written(kind)} is no stop of a controller; give {said}")
    plan, table = load_plan(folder), _table(folder)
    t, entry = _instant(table, at, folder)
    brake = BrakedJoints(plan.trajectory.motion, t, np.array(table["deceleration_rad_s2"]))
    slowed = SlowedClock(plan.trajectory.motion, t, table["slowing_s"])
    stops: list[tuple[str, JointMotion, float]] = [
        (f"stop at {t:.2f} s", *_spill_free(plan, folder, t, entry)),
        ("joints braked", brake, t + brake.duration)
        if kind == "joints"
        else ("time scaled", slowed, t + slowed.duration),
    ]
    length = max(end for _, _, end in stops) + after_end
    rules = replace(plan.scene.motion, end="residual", residual_fraction=table["residual_fraction"])
    plan = replace(plan, scene=replace(plan.scene, motion=rules))  # liquids may swing on after a stop
    return [_film(plan, name, motion, end, rate, length) for name, motion, end in stops]


def _table(folder: Path) -> dict[str, Any]:
    file = folder / STOPS_FILE
    try:
        return json.loads(file.read_text(encoding="utf-8"))
    except OSError:
        raise PlanFolderError(f"{folder}: no stops have been found of this plan; run nospill stops {folder}") from None
    except ValueError:
        raise PlanFolderError(f"{file}: damaged; run nospill stops {folder} again") from None


def _instant(table: dict[str, Any], at: str, folder: Path) -> tuple[float, dict[str, Any]]:
    """The instant, s, and what the table has of its stop."""
    try:
        t = quantity(at, "time")
    except ScenarioError as error:
        raise ScenarioError(f"--stop: {error}") from None
    entries = table["stops"]
    entry = min(entries, key=lambda item: abs(item["t_s"] - t))
    if abs(entry["t_s"] - t) > _ON_GRID:
        raise ScenarioError(
            f"--stop {as_written(at)}: no stop of {folder} begins then, the nearest one at {entry['t_s']:.6g} s; they "
            f"begin at {len(entries)} instants from {entries[0]['t_s']:.6g} to {entries[-1]['t_s']:.6g} s"
        )
    return float(entry["t_s"]), entry


def _spill_free(plan: Plan, folder: Path, t: float, entry: dict[str, Any]) -> tuple[JointMotion, float]:
    """The plan until an instant, s, and its stop from there, as one motion; when that ends, s."""
    record = plan.trajectory
    if entry["file"] is None:  # the rest of the plan is its stop
        return record.motion, plan.duration
    samples = EXPORTERS["csv"].read(folder / STOPS_FOLDER / entry["file"], plan.scene)
    rows = round((t - float(record.t[0])) * record.rate)
    q = np.concatenate([record.joint_position[:rows], samples.position])
    return QUINTIC_SPLINE.motion(JointSamples(np.arange(len(q)) / record.rate, q)), t + float(entry["stops_in_s"])


def _film(plan: Plan, name: str, motion: JointMotion, end: float, rate: float, length: float) -> Film:
    """A motion from rest to rest as the pictures of a plan with its name and verdict."""
    record = record_to_rest(motion, end, plan.trajectory.rate, plan.scene, _STANDS)
    try:
        judgement = judge_joints(record, plan.scene)
    except ModelError as error:
        raise ModelError(f"{name}: liquids move beyond the slosh model and cannot be drawn ({error})") from None
    scene = replace(plan.scene, name=name)
    shown = replace(plan, scene=scene, trajectory=record, certificate=judgement.certificate, judgement=judgement)
    return make_film(shown, judgement, rate=rate, length=length)
