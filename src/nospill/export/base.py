"""What an exporter is: one robot controller's file format, written and read back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.scene import Scene
from nospill.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Exporter:
    """One file format for robot controllers. Exporters format the samples; they never resample.

    Attributes:
        name: key in the table of exporters.
        file_name: name of the file in a plan folder.
        title: what the format is, in one line.
        reason_against: the sentence that says why a scene cannot be written in this format, or None when it can.
        write: (trajectory, scene, path) -> file; raises ScenarioError with that sentence, PlanFolderError for the disk.
        read: (path, scene) -> time (samples,) in s from 0 and joint positions (samples, joints) in rad; raises
            PlanFolderError for a file that is missing or not in this format.
    """

    name: str
    file_name: str
    title: str
    reason_against: Callable[[Scene], str | None]
    write: Callable[[Trajectory, Scene, Path], None]
    read: Callable[[Path, Scene], tuple[np.ndarray, np.ndarray]]
