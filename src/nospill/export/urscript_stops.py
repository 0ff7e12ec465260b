"""A URScript program of a plan that may be stopped: after some of its targets it looks at an input, and branches.

Each branch holds the targets of one stop, the first of them a period after the target before it, and ends the program.
The rest is the program of `urscript`, and is read as one.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from nospill.core.files import atomic_text
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export.urscript import (
    SOCKET,
    Lines,
    Settings,
    comment_lines,
    frame_lines,
    numbered_lines,
    program_samples,
    reason_against,
    target_lines,
    targets_of,
)
from nospill.motion.interpolation import JointSamples
from nospill.scene.scene import Scene

ASKED = "if get_standard_digital_in(0):"
"""Stop is pressed."""
_END = ["stopj(2.0)", "halt", "end"]


def write_stopping_program(samples: JointSamples, stops: Mapping[int, JointSamples], scene: Scene, path: Path) -> None:
    """Write the targets of a motion with a branch to each stop.

    Args:
        samples: of the motion, at 500 or 125 Hz.
        stops: by the number of the target at which a stop begins; its first sample is that target.
        scene: with the robot.
        path: file to write.

    Raises:
        ScenarioError: URScript does not move this arm, or not at this rate.
        PlanFolderError: the disk refuses.
    """
    rate, settings = round(samples.rate, 3), Settings()
    reason = reason_against(scene, rate)
    if reason is not None:
        raise ScenarioError(reason)
    before, after = frame_lines(samples.position[0], scene, SOCKET)
    lines = [before[0], *comment_lines(scene, rate)]
    lines.append(f"  # stops spill-free at {len(stops)} targets if standard digital input 0 is on; no safety function")
    lines += before[1:]
    for number, target in enumerate(target_lines(samples.position, rate, settings)):
        lines.append(target)
        if number in stops:
            branch = target_lines(stops[number].position[1:], rate, settings)
            lines += [f"  {ASKED}", *(f"  {line}" for line in branch), *(f"    {line}" for line in _END[:-1]), "  end"]
    atomic_text(path, "\n".join([*lines, *after, ""]))


def read_stopping_program(path: Path, scene: Scene) -> tuple[JointSamples, dict[int, JointSamples]]:
    """The motion and the stops of a program, as `write_stopping_program` took them.

    Raises:
        PlanFolderError: it is none, or has other lines.
    """
    rest: Lines = []
    branches: dict[int, Lines] = {}
    inside: Lines | None = None
    for line in numbered_lines(path):
        if inside is not None:
            inside.append(line)
            if line[1] == _END[-1]:
                inside = None
        elif line[1] == ASKED:
            inside = branches[sum(text.startswith("servoj(") for _, text in rest) - 1] = []
        else:
            rest.append(line)
    samples = program_samples(rest, scene, path)
    stops = {number: _stop(samples, number, lines, path) for number, lines in branches.items()}
    return samples, stops


def _stop(samples: JointSamples, number: int, lines: Lines, path: Path) -> JointSamples:
    rows, periods, others = targets_of(lines, path)
    where = f"{path}, line {lines[0][0] if lines else 0}"
    if not rows or number < 0:
        raise PlanFolderError(f"{where}: this branch is no stop after a target; write it again with nospill stops")
    if [(line, place) for _, line, place in others] != [(line, len(rows)) for line in _END]:
        raise PlanFolderError(f"{where}: this branch does more than nospill wrote there")
    if {round(period * samples.rate, 6) for period in periods} != {1.0}:
        raise PlanFolderError(f"{where}: the period of servoj is not that of the motion")
    position = np.vstack([samples.position[number], rows])
    return JointSamples(np.arange(len(position)) / samples.rate, position)
