"""Writing of a plan folder in one piece."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from nospill.approach import Segment, segment_text
from nospill.core.files import atomic_folder
from nospill.errors import PlanFolderError
from nospill.export.plan_files import write_plan_files
from nospill.judge.verdict import Certificate
from nospill.laws.parameters import flatten
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.motion.trajectory import Trajectory, trajectory_text
from nospill.plans.names import (
    APPROACH_FILE,
    CERTIFICATE_FILE,
    SCENARIO_FILE,
    SUMMARY_FILE,
    TRAJECTORY_FILE,
    is_plan_folder,
)
from nospill.scenario import scenario_text, scene_from_table
from nospill.scene.scene import ApproachRules, Scene


def write_folder(
    folder: str | Path,
    *,
    scene: Scene,
    trajectory: Trajectory,
    certificate: Certificate,
    approach: Segment | None,
    summary: Callable[[float], dict[str, Any]],
    extra: Callable[[Path], None] | None = None,
) -> None:
    """Write a plan folder in one piece: a killed run leaves the old folder or none.

    Args:
        folder: place of the plan folder; an earlier plan there is replaced.
        scene: as its scenario says.
        trajectory: the motion.
        certificate: the verdict.
        approach: from where the arm is to the start of the trajectory, where there is one.
        summary: how long the other files took to write, s -> the summary.
        extra: writes more files into the folder while it is being made, for example figures.

    Raises:
        PlanFolderError: the folder holds something else or cannot be written, or the scene is not what its scenario
            says.
    """
    began = time.perf_counter()
    _require_faithful(scene)
    with atomic_folder(folder, replaceable=is_plan_folder) as partial:
        _write(partial / SCENARIO_FILE, scenario_text(scene))
        _write(partial / TRAJECTORY_FILE, trajectory_text(trajectory))
        _write(partial / CERTIFICATE_FILE, _json(certificate.to_dict()))
        if approach is not None:
            _write(partial / APPROACH_FILE, segment_text(approach))
        write_plan_files(trajectory, scene, partial)
        if extra is not None:
            extra(partial)
        _write(partial / SUMMARY_FILE, _json(summary(time.perf_counter() - began)))


def _require_faithful(scene: Scene) -> None:
    """A scene altered in Python no longer agrees with the scenario text that would be kept with the plan."""
    again = scene_from_table(scene.source, name=scene.name)
    same = structure_of(again) == structure_of(scene) and again.motion == scene.motion
    same = same and _same_approach(again.approach, scene.approach)
    same = same and [item.tolerance for item in again.cargo] == [item.tolerance for item in scene.cargo]
    if not same or not np.array_equal(flatten(numbers_of(again)), flatten(numbers_of(scene))):
        raise PlanFolderError(
            f"{scene.name}: the scene was changed after it was read, so the scenario kept with the plan would "
            "contradict it; change the table scene.source and build the scene with nospill.scenario.scene_from_table"
        )


def _same_approach(first: ApproachRules | None, second: ApproachRules | None) -> bool:
    if first is None or second is None:
        return first is second
    return all(np.array_equal(getattr(first, item.name), getattr(second, item.name)) for item in fields(first))


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _json(value: Any) -> str:
    return json.dumps(value, indent=2, allow_nan=False) + "\n"
