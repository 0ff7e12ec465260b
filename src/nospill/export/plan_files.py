"""The controller files that every plan folder holds, written with the plan and compared with it later."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nospill.export import EXPORTERS
from nospill.motion.control import commanded
from nospill.motion.holds import held_samples
from nospill.motion.interpolation import JointSamples
from nospill.motion.trajectory import Trajectory
from nospill.scene.scene import Scene

TOLERANCE = 1e-9
"""rad; what the formats' printing may change is far below."""


def write_plan_files(trajectory: Trajectory, scene: Scene, folder: Path) -> None:
    """Write the files that belong to a plan folder, as far as the scene fits their formats.

    Raises:
        PlanFolderError: the disk refuses.
    """
    for exporter in EXPORTERS.values():
        if exporter.plan_file is not None and exporter.reason_against(scene, scene.output_rate) is None:
            samples = held_samples(commanded(trajectory, scene.controller), scene.motion)
            exporter.write(samples, scene, folder / exporter.plan_file)


def compare_plan_files(trajectory: Trajectory, scene: Scene, folder: Path) -> dict[str, str | None]:
    """Read the controller files of a plan folder back and compare their joints with the trajectory's.

    A file that is not there moves nothing and is not missed.

    Returns:
        By file name, what differs in one sentence; None where nothing does.

    Raises:
        PlanFolderError: a file cannot be read or is not in its format.
    """
    present = [item for item in EXPORTERS.values() if item.plan_file and (folder / item.plan_file).is_file()]
    return {
        str(item.plan_file): _difference(item.read(folder / str(item.plan_file), scene), trajectory, scene)
        for item in present
    }


def _difference(samples: JointSamples, trajectory: Trajectory, scene: Scene) -> str | None:
    held = held_samples(commanded(trajectory, scene.controller), scene.motion)
    wanted = held.position
    if samples.position.shape != wanted.shape:
        return f"holds {len(samples.t)} samples of the motion, the trajectory {len(wanted)}"
    late = float(np.max(np.abs(samples.t - held.t)))
    if late > 1.0 / trajectory.rate / 2.0:
        return f"is played at another rate: {late:.3g} s off the trajectory's times"
    apart = np.abs(samples.position - wanted)
    row, joint = np.unravel_index(int(np.argmax(apart)), apart.shape)
    if apart[row, joint] <= TOLERANCE:
        return None
    return (
        f"is not the motion of the trajectory: {trajectory.joints[joint]} differs by {apart[row, joint]:.4g} rad "
        f"at t = {held.t[row]:.3f} s"
    )
