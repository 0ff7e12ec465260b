"""Writing of a plan folder in one piece."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from nospill.approach import Segment, segment_text
from nospill.certification.verdict import Certificate
from nospill.core.files import atomic_folder
from nospill.export.plan_files import write_plan_files
from nospill.motion.trajectory import Trajectory, trajectory_text
from nospill.plans.names import (
    APPROACH_FILE,
    CERTIFICATE_FILE,
    SCENARIO_FILE,
    SUMMARY_FILE,
    TRAJECTORY_FILE,
    is_plan_folder,
)
from nospill.scene.scene import Scene


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
        scene: the task, as it was read.
        trajectory: the motion.
        certificate: the verdict.
        approach: from where the arm is to the start of the trajectory, where there is one.
        summary: how long the other files took to write, s -> the summary.
        extra: writes more files into the folder while it is being made, for example figures.

    Raises:
        PlanFolderError: the folder holds something else or cannot be written.
        ScenarioError: the scene is a copy made with `dataclasses.replace`.
    """
    began = time.perf_counter()
    scene.require_as_read()
    with atomic_folder(folder, replaceable=is_plan_folder) as partial:
        _write(partial / SCENARIO_FILE, scene.text())
        _write(partial / TRAJECTORY_FILE, trajectory_text(trajectory))
        _write(partial / CERTIFICATE_FILE, _json(certificate.to_dict()))
        if approach is not None:
            _write(partial / APPROACH_FILE, segment_text(approach))
        write_plan_files(trajectory, scene, partial)
        if extra is not None:
            extra(partial)
        _write(partial / SUMMARY_FILE, _json(summary(time.perf_counter() - began)))


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


def _json(value: Any) -> str:
    return json.dumps(value, indent=2, allow_nan=False) + "\n"
